//! Finding a GPU, and what goes wrong with it.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{Adapter, DeviceType, Instance, InstanceDescriptor};

use super::Error;

/// Whether a software GPU, such as llvmpipe, counts as a GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Software {
    /// It does not: it is slower than the CPU's own renderer.
    #[default]
    Refused,
    /// It does, for tests.
    Allowed,
}

impl Software {
    /// Allowed where the environment variable `POCKETNERF_SOFTWARE_GPU` is set: what programs
    /// do, so that they can be tested.
    #[must_use]
    pub fn from_environment() -> Self {
        match std::env::var_os("POCKETNERF_SOFTWARE_GPU") {
            Some(_) => Self::Allowed,
            None => Self::Refused,
        }
    }
}

/// An open GPU.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    name: String,
    fault: Fault,
}

/// What the device has complained of, the first time.
#[derive(Clone, Debug, Default)]
struct Fault(Arc<Mutex<Option<String>>>);

impl Fault {
    fn note(&self, what: impl ToString) {
        let mut fault = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        fault.get_or_insert_with(|| what.to_string());
    }

    fn get(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// The GPUs of this machine and the interfaces that they are reached by, the one that
/// [`Gpu::open`] would take first.
#[must_use]
pub fn adapters() -> Vec<String> {
    found().iter().map(described).collect()
}

/// All adapters, the best first.
fn found() -> Vec<Adapter> {
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    let mut all = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    // One adapter may be reached by several interfaces: the order in which they are found
    // stands.
    all.sort_by_key(|adapter| match adapter.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    });
    all
}

fn described(adapter: &Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({})", info.name, info.backend)
}

impl Gpu {
    /// Opens the best GPU of this machine.
    ///
    /// # Errors
    /// [`Error::NoAdapter`], [`Error::Software`] or [`Error::Open`].
    pub fn open(software: Software) -> Result<Self, Error> {
        let adapter = found().into_iter().next().ok_or(Error::NoAdapter)?;
        let name = described(&adapter);
        let is_software = adapter.get_info().device_type == DeviceType::Cpu;
        if is_software && software == Software::Refused {
            return Err(Error::Software(name));
        }
        // All the memory that it gives at a time: pictures and tables are large.
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("pocketnerf"),
            required_limits: adapter.limits(),
            // It needs none; it tells times where it can.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened
            .map_err(|error| Error::Open { name: name.clone(), reason: error.to_string() })?;
        let fault = Fault::default();
        let (uncaptured, lost) = (fault.clone(), fault.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| uncaptured.note(error)));
        device.set_device_lost_callback(move |_, why| lost.note(why));
        Ok(Self { device, queue, name, fault })
    }

    /// What it is called, and the interface that it is reached by.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    pub(crate) const fn device(&self) -> &wgpu::Device {
        &self.device
    }

    pub(crate) const fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Whether all that was asked of it so far has been done.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.fault.get().map_or(Ok(()), |what| Err(Error::Device(one_line(&what))))
    }

    /// Bytes of a buffer at most.
    pub(crate) fn most_bytes(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_buffer_size.min(limits.max_storage_buffer_binding_size)
    }

    /// A buffer for the shader to read.
    pub(crate) fn upload(&self, what: &'static str, bytes: &[u8]) -> Result<wgpu::Buffer, Error> {
        // Buffers are never empty.
        let size = (bytes.len() as u64).next_multiple_of(4).max(16);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = self.buffer(what, size, usage)?;
        if !bytes.is_empty() {
            self.queue.write_buffer(&buffer, 0, bytes);
        }
        Ok(buffer)
    }

    /// A buffer of constants.
    pub(crate) fn uniform(&self, bytes: &[u8]) -> Result<wgpu::Buffer, Error> {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let buffer = self.buffer("constants", bytes.len() as u64, usage)?;
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    /// A buffer of so many bytes.
    pub(crate) fn buffer(
        &self,
        what: &'static str,
        size: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, Error> {
        let most = self.most_bytes();
        if size > most {
            return Err(Error::TooLarge { what, bytes: size, most });
        }
        let descriptor =
            wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
        let buffer = self.device.create_buffer(&descriptor);
        self.check()?;
        Ok(buffer)
    }

    /// What a program reads and writes: each buffer with the number of its binding.
    pub(crate) fn group<'b>(
        &self,
        pipeline: &wgpu::ComputePipeline,
        buffers: impl IntoIterator<Item = (u32, &'b wgpu::Buffer)>,
    ) -> Result<wgpu::BindGroup, Error> {
        let entries = buffers.into_iter().map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        });
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries.collect::<Vec<_>>(),
        });
        self.check()?;
        Ok(group)
    }
}

/// Drivers' messages have several lines.
fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_first_is_said() {
        let fault = Fault::default();
        assert_eq!(fault.get(), None);
        fault.note("out\n of  memory");
        fault.note("lost");
        assert_eq!(fault.get().as_deref().map(one_line).as_deref(), Some("out of memory"));
    }
}
