//! The table of kernels: what each is made of and bound to; and their pipelines, made when they are first needed.

use std::collections::HashMap;

use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BufferBindingType, BufferSize,
    ComputePipeline, PipelineCompilationOptions, PipelineLayoutDescriptor, ShaderModule, ShaderModuleDescriptor,
    ShaderSource, ShaderStages,
};

use super::settings::Storage;

/// Bytes of one uniform, and how far apart they stand.
pub const UNIFORM_BYTES: u64 = 256;

/// A kernel, in the order of a frame; [`Kernel::Heights`] is for whoever looks between the passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kernel {
    Columns,
    Rows,
    Differences,
    Foam,
    Quantise,
    Heights,
}

/// How a kernel sees a buffer.
#[derive(Clone, Copy, Debug)]
enum Seen {
    /// A uniform at an offset of its own.
    Uniform,
    Read,
    Write,
}

struct Row {
    label: &'static str,
    /// Pieces of its shader, the entry point's last. `None` stands for the storage between the passes.
    pieces: &'static [Option<&'static str>],
    bindings: &'static [Seen],
    /// Whether it is another one for every grid size.
    sized: bool,
}

macro_rules! shader {
    ($name:literal) => {
        include_str!(concat!("shaders/", $name, ".wgsl"))
    };
}

impl Kernel {
    pub const ALL: [Self; 6] =
        [Self::Columns, Self::Rows, Self::Differences, Self::Foam, Self::Quantise, Self::Heights];

    fn row(self) -> Row {
        use Seen::{Read, Uniform, Write};
        const PHASE: Option<&str> = Some(shader!("phase"));
        const EVOLVE: Option<&str> = Some(shader!("evolve"));
        const TRANSFORM: Option<&str> = Some(shader!("transform"));
        const INTERMEDIATE: Option<&str> = Some(shader!("intermediate"));
        const HEADER: Option<&str> = Some(shader!("header"));
        const ASSEMBLE: Option<&str> = Some(shader!("assemble"));
        const COLUMNS: &[Option<&str>] =
            &[PHASE, EVOLVE, Some(shader!("operator")), TRANSFORM, None, INTERMEDIATE, Some(shader!("columns"))];
        const ROWS: &[Option<&str>] = &[TRANSFORM, None, INTERMEDIATE, HEADER, ASSEMBLE, Some(shader!("rows"))];
        match self {
            Self::Columns => Row {
                label: "swellcast.columns",
                pieces: COLUMNS,
                bindings: &[Uniform, Read, Read, Write],
                sized: true,
            },
            Self::Rows => Row {
                label: "swellcast.rows",
                pieces: ROWS,
                bindings: &[Uniform, Read, Read, Write, Write],
                sized: true,
            },
            Self::Differences => Row {
                label: "swellcast.differences",
                pieces: &[HEADER, ASSEMBLE, Some(shader!("differences"))],
                bindings: &[Uniform, Read, Write],
                sized: false,
            },
            Self::Foam => Row {
                label: "swellcast.foam",
                pieces: &[HEADER, Some(shader!("foam"))],
                bindings: &[Uniform, Read, Write, Write],
                sized: false,
            },
            Self::Quantise => Row {
                label: "swellcast.quantise",
                pieces: &[HEADER, Some(shader!("quantise"))],
                bindings: &[Read, Read, Write, Write],
                sized: false,
            },
            Self::Heights => Row {
                label: "swellcast.heights",
                pieces: &[PHASE, EVOLVE, Some(shader!("heights"))],
                bindings: &[Uniform, Read, Write],
                sized: false,
            },
        }
    }

    /// `swellcast.<pass>`.
    pub fn label(self) -> &'static str {
        self.row().label
    }

    /// The whole shader.
    pub fn source(self, storage: Storage) -> String {
        let stored = match storage {
            Storage::F32 => shader!("stored_f32"),
            Storage::F16 => shader!("stored_f16"),
        };
        self.row().pieces.iter().map(|piece| piece.unwrap_or(stored)).collect::<Vec<_>>().join("\n")
    }

    /// Values of what the shader leaves open, for a grid of n samples a side.
    pub fn constants(self, n: usize) -> Vec<(&'static str, f64)> {
        if !self.row().sized {
            return Vec::new();
        }
        let bits = n.trailing_zeros();
        // As many steps of 8 as leave steps of 4.
        let fours = [0, 2, 1][bits as usize % 3];
        vec![("N", n as f64), ("EIGHTS", f64::from((bits - 2 * fours) / 3)), ("FOURS", f64::from(fours))]
    }
}

/// Compiled kernels of one device.
pub struct Kernels {
    storage: Storage,
    compiled: HashMap<Kernel, (ShaderModule, BindGroupLayout)>,
    pipelines: HashMap<(Kernel, usize), ComputePipeline>,
}

impl Kernels {
    /// Reads every shader.
    pub fn new(device: &wgpu::Device, storage: Storage) -> Self {
        let compile = |kernel: Kernel| {
            let row = kernel.row();
            let source = ShaderSource::Wgsl(kernel.source(storage).into());
            let module = device.create_shader_module(ShaderModuleDescriptor { label: Some(row.label), source });
            let entries: Vec<_> = (0..).zip(row.bindings).map(|(binding, seen)| entry(binding, *seen)).collect();
            let layout = BindGroupLayoutDescriptor { label: Some(row.label), entries: &entries };
            (kernel, (module, device.create_bind_group_layout(&layout)))
        };
        Self { storage, compiled: Kernel::ALL.into_iter().map(compile).collect(), pipelines: HashMap::new() }
    }

    /// Numbers between the passes.
    pub fn storage(&self) -> Storage {
        self.storage
    }

    /// How a kernel's buffers are bound.
    pub fn layout(&self, kernel: Kernel) -> &BindGroupLayout {
        &self.compiled[&kernel].1
    }

    /// Makes sure that the pipeline for a grid of n samples a side is there.
    pub fn prepare(&mut self, device: &wgpu::Device, kernel: Kernel, n: usize) {
        let (module, layout) = &self.compiled[&kernel];
        let make = || {
            let label = Some(kernel.label());
            let layouts = [Some(layout)];
            let layout = PipelineLayoutDescriptor { label, bind_group_layouts: &layouts, immediate_size: 0 };
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label,
                layout: Some(&device.create_pipeline_layout(&layout)),
                module,
                entry_point: Some("main"),
                compilation_options: PipelineCompilationOptions {
                    constants: &kernel.constants(n),
                    // Every word is written before it is read.
                    zero_initialize_workgroup_memory: false,
                },
                cache: None,
            })
        };
        self.pipelines.entry((kernel, key(kernel, n))).or_insert_with(make);
    }

    /// A pipeline that was prepared.
    pub fn pipeline(&self, kernel: Kernel, n: usize) -> &ComputePipeline {
        &self.pipelines[&(kernel, key(kernel, n))]
    }
}

/// One pipeline serves every grid where the kernel doesn't depend on it.
fn key(kernel: Kernel, n: usize) -> usize {
    if kernel.row().sized { n } else { 0 }
}

fn entry(binding: u32, seen: Seen) -> BindGroupLayoutEntry {
    let (ty, dynamic) = match seen {
        Seen::Uniform => (BufferBindingType::Uniform, true),
        Seen::Read => (BufferBindingType::Storage { read_only: true }, false),
        Seen::Write => (BufferBindingType::Storage { read_only: false }, false),
    };
    let min_binding_size = if dynamic { BufferSize::new(UNIFORM_BYTES) } else { None };
    BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::COMPUTE,
        ty: BindingType::Buffer { ty, has_dynamic_offset: dynamic, min_binding_size },
        count: None,
    }
}
