//! Chooses an adapter, says why, and opens a device that reports what goes wrong with it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use wgpu::{AdapterInfo, Backends, DeviceType, Features, Limits, PollType, SubmissionIndex};

use super::settings::{GpuError, GpuSettings};
use crate::backend::BackendError;

/// A device that has not done its work after this long hangs; one that a processor plays is slow, and has longer.
const PATIENCE: [Duration; 2] = [Duration::from_secs(10), Duration::from_secs(120)];

/// An open device, its queue, and the first thing that went wrong with it.
pub struct Device {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Name, kind and driver, for people.
    pub adapter: String,
    /// Whether passes can be timed.
    pub timestamps: bool,
    patience: Duration,
    fault: Arc<Mutex<Option<String>>>,
}

impl Device {
    pub fn open(settings: &GpuSettings) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: Backends::PRIMARY,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapters = pollster::block_on(instance.enumerate_adapters(Backends::PRIMARY));
        let infos: Vec<AdapterInfo> = adapters.iter().map(wgpu::Adapter::get_info).collect();
        let (chosen, why) = choose(&infos, settings)?;
        let (adapter, name) = (&adapters[chosen], describe(&infos[chosen]));
        let refused = |reason: String| GpuError::Refused { adapter: name.clone(), reason };
        let timestamps = adapter.features().contains(Features::TIMESTAMP_QUERY);
        // Every kernel keeps to the defaults; only how large a sea may be grows with the device.
        let has = adapter.limits();
        let limits = Limits {
            max_buffer_size: has.max_buffer_size.max(Limits::default().max_buffer_size),
            max_storage_buffer_binding_size: (has.max_storage_buffer_binding_size)
                .max(Limits::default().max_storage_buffer_binding_size),
            ..Limits::default()
        };
        let asked = wgpu::DeviceDescriptor {
            label: Some("swellcast"),
            required_features: if timestamps { Features::TIMESTAMP_QUERY } else { Features::empty() },
            required_limits: limits,
            memory_hints: wgpu::MemoryHints::Performance,
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&asked));
        let (device, queue) = opened.map_err(|error| refused(error.to_string()))?;
        let fault = Arc::new(Mutex::new(None));
        let note = |fault: &Arc<Mutex<Option<String>>>, what: String| {
            fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(what);
        };
        let of_errors = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&of_errors, error.to_string())));
        let of_loss = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, text| note(&of_loss, format!("{reason:?}: {text}")));
        tracing::info!(adapter = name, "{why}");
        let patience = PATIENCE[usize::from(infos[chosen].device_type == DeviceType::Cpu)];
        Ok(Self { device, queue, adapter: name, timestamps, patience, fault })
    }

    /// What went wrong first, if anything did.
    pub fn check(&self) -> Result<(), BackendError> {
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        fault.as_ref().map_or(Ok(()), |what| Err(BackendError::DeviceLost(what.clone())))
    }

    /// Waits until the device has done so much.
    pub fn wait(&self, until: SubmissionIndex) -> Result<(), BackendError> {
        let wait = PollType::Wait { submission_index: Some(until), timeout: Some(self.patience) };
        // A driver that reports the loss while it is waited for makes wgpu panic.
        let done = catch_unwind(AssertUnwindSafe(|| self.device.poll(wait)));
        self.check()?;
        let done = done.map_err(|_| BackendError::DeviceLost("it was lost while it was waited for".to_owned()))?;
        done.map(drop).map_err(|error| BackendError::DeviceLost(error.to_string()))
    }
}

fn describe(info: &AdapterInfo) -> String {
    format!("{} ({:?}, {:?}, {} {})", info.name, info.device_type, info.backend, info.driver, info.driver_info)
}

/// The adapter to take, and why.
fn choose(adapters: &[AdapterInfo], settings: &GpuSettings) -> Result<(usize, String), GpuError> {
    let all = || adapters.iter().map(|info| info.name.as_str()).collect::<Vec<_>>().join(", ");
    if let Some(wanted) = &settings.adapter {
        let by_number = wanted.parse().ok().filter(|number| *number < adapters.len());
        let wanted_name = wanted.to_lowercase();
        let named = || adapters.iter().position(|info| info.name.to_lowercase().contains(&wanted_name));
        return match by_number.or_else(named) {
            Some(found) => Ok((found, format!("taken because it was asked for as {wanted:?}"))),
            None => Err(GpuError::NoAdapter(format!("none is named {wanted:?}; there are [{}]", all()))),
        };
    }
    let rank = |info: &AdapterInfo| match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    let best = (0..adapters.len()).min_by_key(|i| rank(&adapters[*i]));
    match best {
        None => Err(GpuError::NoAdapter("no driver offers one".to_owned())),
        Some(best) if adapters[best].device_type == DeviceType::Cpu && !settings.software => {
            Err(GpuError::NoAdapter(format!("{} is a software renderer", adapters[best].name)))
        }
        Some(best) => {
            let kind = adapters[best].device_type;
            Ok((best, format!("the best of {} adapters: a {kind:?} of [{}]", adapters.len(), all())))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapters() -> Vec<AdapterInfo> {
        let of =
            |name: &str, kind| AdapterInfo { name: name.to_owned(), ..AdapterInfo::new(kind, wgpu::Backend::Vulkan) };
        vec![
            of("llvmpipe", DeviceType::Cpu),
            of("Board UHD", DeviceType::IntegratedGpu),
            of("Big Card 9000", DeviceType::DiscreteGpu),
        ]
    }

    fn chosen(adapters: &[AdapterInfo], adapter: Option<&str>, software: bool) -> Option<usize> {
        let settings = GpuSettings { adapter: adapter.map(str::to_owned), software, ..GpuSettings::default() };
        choose(adapters, &settings).ok().map(|(chosen, _)| chosen)
    }

    #[test]
    fn the_best_adapter_is_taken_unless_one_is_named() {
        let all = adapters();
        assert_eq!(chosen(&all, None, false), Some(2));
        assert_eq!(chosen(&all, Some("uhd"), false), Some(1));
        assert_eq!(chosen(&all, Some("0"), false), Some(0), "a software renderer that is named will do");
        assert_eq!(chosen(&all, Some("other"), false), None);
        assert_eq!(chosen(&all[..1], None, false), None, "software is no GPU");
        assert_eq!(chosen(&all[..1], None, true), Some(0));
        assert_eq!(chosen(&[], None, true), None);
    }
}
