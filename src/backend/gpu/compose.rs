//! The dispatches of a frame, with what each is told.

use wgpu::{BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferBinding, BufferUsages};

use super::device::Device;
use super::kernels::{Kernel, Kernels, UNIFORM_BYTES};

/// Most uniforms of a frame: three bundles in two passes, differences and foam of every level of 16 cascades.
const MOST_UNIFORMS: u64 = 2048;

/// One kernel over one grid.
pub struct Dispatch {
    pub kernel: Kernel,
    /// Samples a side of the grid whose pipeline it takes.
    n: usize,
    bind: BindGroup,
    uniform: Option<u32>,
    groups: [u32; 2],
}

/// A frame that is being put together.
pub struct Composer<'a> {
    pub device: &'a Device,
    pub kernels: &'a mut Kernels,
    pub uniforms: &'a Buffer,
    /// The frame's name, which kernels leave beside what they make; exact as a 32-bit float, and never 0.
    pub frame: u32,
    told: Vec<u8>,
    dispatches: Vec<Dispatch>,
}

/// The buffer that uniforms of a frame stand in.
pub fn uniform_buffer(device: &Device) -> Buffer {
    buffer(device, "uniforms", MOST_UNIFORMS * UNIFORM_BYTES, BufferUsages::UNIFORM)
}

/// A buffer that may be written and read by copies, too. New buffers are zero.
pub fn buffer(device: &Device, label: &str, bytes: u64, usage: BufferUsages) -> Buffer {
    device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes,
        usage: usage | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

/// A buffer for kernels.
pub fn storage(device: &Device, label: &str, bytes: u64) -> Buffer {
    buffer(device, label, bytes, BufferUsages::STORAGE)
}

impl<'a> Composer<'a> {
    /// A frame of this name.
    pub fn new(device: &'a Device, kernels: &'a mut Kernels, uniforms: &'a Buffer, frame: u32) -> Self {
        Self { device, kernels, uniforms, frame, told: Vec::new(), dispatches: Vec::new() }
    }

    /// Binds buffers to a kernel, in its order. Those that are told something find it at the offset of the dispatch.
    pub fn bind(&self, kernel: Kernel, buffers: &[&Buffer]) -> BindGroup {
        let told = self.uniforms.as_entire_buffer_binding();
        let told = BufferBinding { size: wgpu::BufferSize::new(UNIFORM_BYTES), ..told };
        let told = std::iter::once(BindingResource::Buffer(told));
        let resources = told.chain(buffers.iter().map(|buffer| buffer.as_entire_binding()));
        self.bind_resources(kernel, resources)
    }

    /// Binds resources to a kernel that is told nothing.
    pub fn bind_resources<'b>(
        &self,
        kernel: Kernel,
        resources: impl Iterator<Item = BindingResource<'b>>,
    ) -> BindGroup {
        let entries: Vec<_> =
            (0..).zip(resources).map(|(binding, resource)| BindGroupEntry { binding, resource }).collect();
        self.device.device.create_bind_group(&BindGroupDescriptor {
            label: Some(kernel.label()),
            layout: self.kernels.layout(kernel),
            entries: &entries,
        })
    }

    /// Adds a dispatch over a grid of n samples a side; `told` is empty for a kernel that is told nothing.
    pub fn add(&mut self, kernel: Kernel, n: usize, bind: &BindGroup, told: &[u32], groups: [usize; 2]) {
        self.kernels.prepare(&self.device.device, kernel, n);
        let uniform = (!told.is_empty()).then_some(self.told.len() as u32);
        if uniform.is_some() {
            self.told.extend_from_slice(bytemuck::cast_slice(told));
            self.told.resize(self.told.len().next_multiple_of(UNIFORM_BYTES as usize), 0);
        }
        let groups = groups.map(|groups| groups as u32);
        self.dispatches.push(Dispatch { kernel, n, bind: bind.clone(), uniform, groups });
    }

    /// Kernels that the frame has, in their order.
    pub fn used(&self) -> Vec<Kernel> {
        let mut used: Vec<Kernel> = self.dispatches.iter().map(|dispatch| dispatch.kernel).collect();
        used.sort_unstable();
        used.dedup();
        used
    }

    /// Records every dispatch, a pass for each kernel, and times passes where there are queries: two of each kernel.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, queries: Option<&wgpu::QuerySet>) {
        self.device.queue.write_buffer(self.uniforms, 0, &self.told);
        for (place, kernel) in (0..).zip(self.used()) {
            let timed = queries.map(|query_set| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(2 * place),
                end_of_pass_write_index: Some(2 * place + 1),
            });
            let described = wgpu::ComputePassDescriptor { label: Some(kernel.label()), timestamp_writes: timed };
            let mut pass = encoder.begin_compute_pass(&described);
            for dispatch in self.dispatches.iter().filter(|dispatch| dispatch.kernel == kernel) {
                pass.set_pipeline(self.kernels.pipeline(kernel, dispatch.n));
                pass.set_bind_group(0, &dispatch.bind, dispatch.uniform.as_slice());
                pass.dispatch_workgroups(dispatch.groups[0], dispatch.groups[1], 1);
            }
        }
    }
}
