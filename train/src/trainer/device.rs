//! What a trainer's steps are taken on.

use std::time::Duration;

use super::backend::Backend;
#[cfg(feature = "gpu")]
use super::backend::OnGpu;
use super::{Trainer, backend, learnt_gains};
use crate::picture::Device;

/// Samples of a step of a GPU, which would be idle with fewer; half of them and so on where they
/// do not fit into its buffers.
const GPU_SAMPLES: [usize; 4] = [1 << 18, 1 << 17, 1 << 16, 1 << 15];

impl Trainer {
    /// From now on steps are taken on `device`, from what is learnt so far. Where it cannot, the
    /// CPU takes them: [`fallback`](Self::fallback) says so.
    pub fn train_on(&mut self, device: Device) {
        self.device = device;
        self.move_to_device();
    }

    /// The same before the first step, with as many samples a step as suit the device.
    pub fn begin_on(&mut self, device: Device) {
        if matches!(device, Device::Cpu) {
            return;
        }
        let before = self.config.samples_per_step;
        for samples in GPU_SAMPLES {
            self.config.samples_per_step = samples;
            self.train_on(device.clone());
            if self.is_on_gpu() {
                return;
            }
        }
        self.config.samples_per_step = before;
    }

    /// Why the CPU takes the steps that another device was to take; `None` where that does.
    #[must_use]
    pub fn fallback(&self) -> Option<String> {
        self.fallback.clone().or_else(|| self.backend.fallback())
    }

    /// Whether steps are taken on a GPU.
    #[must_use]
    pub fn is_on_gpu(&self) -> bool {
        !matches!(self.device, Device::Cpu) && self.fallback().is_none()
    }

    /// How long each kernel of a GPU has taken since [`watch`](Self::watch), in their order.
    #[must_use]
    pub fn kernels(&self) -> Vec<(&'static str, Duration)> {
        self.backend.kernels()
    }

    /// Moves what is learnt to the device.
    pub(super) fn move_to_device(&mut self) {
        let (poses, gains) = (self.poses.as_ref(), learnt_gains(&self.source, &self.config));
        let simd = self.backend.simd();
        let Ok(mut cpu) = backend(&self.config, &self.space, poses, gains, simd) else { return };
        cpu.upload(self.backend.download().clone());
        self.fallback = None;
        match &self.device {
            Device::Cpu => self.backend = Box::new(cpu),
            #[cfg(feature = "gpu")]
            Device::Gpu(gpu) => {
                let scene = (self.space, self.sampling, self.grid.view());
                let cameras = self.source.cameras().iter().map(|camera| camera.position());
                let cameras: Vec<[f32; 3]> = cameras.collect();
                let samples = self.config.samples_per_step;
                match OnGpu::new(gpu, cpu, scene, &cameras, samples) {
                    Ok(own) => self.backend = Box::new(own),
                    Err((cpu, why)) => {
                        (self.backend, self.fallback) = (cpu, Some(why.to_string()));
                    }
                }
            }
        }
    }
}
