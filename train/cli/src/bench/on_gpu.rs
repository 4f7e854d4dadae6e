//! What a training step costs on a GPU, kernel by kernel.

use std::fmt;
use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::picture::Device;
use pocketnerf_train::trainer::{Length, Run, TrainConfig, Trainer};
use serde::Serialize;

use super::BenchError;

/// One in so many steps is not timed: until the occupancy knows what is empty.
const WARM_UP: u32 = 5;
/// One in so many steps is timed kernel by kernel, after the others: it takes longer.
const WATCHED: u32 = 10;

/// What a training step costs on a GPU.
#[derive(Clone, Debug, Serialize)]
pub struct OnGpu {
    /// The GPU.
    pub gpu: String,
    /// Dataset that training was timed on.
    pub dataset: String,
    /// Steps that were timed.
    pub steps: u32,
    /// Wall time of these steps.
    pub seconds: f64,
    /// Samples at which the field was asked, by seconds.
    pub samples_per_second: f64,
    /// Samples of a step.
    pub samples_per_step: f64,
    /// Samples by rays.
    pub samples_per_ray: f64,
    /// PSNR of the last rays, dB.
    pub train_psnr: f64,
    /// Time of the GPU for a step, microseconds; `None` where it has no timestamps.
    pub gpu_microseconds: Option<f64>,
    /// The same kernel by kernel, in their order.
    pub kernels: Vec<Kernel>,
}

/// What a kernel takes.
#[derive(Clone, Debug, Serialize)]
pub struct Kernel {
    /// Its entry point.
    pub name: &'static str,
    /// All its dispatches in a step, microseconds.
    pub microseconds: f64,
}

/// Trains for so many steps on `device`.
///
/// # Errors
/// When the device does not train, or training diverges.
pub fn measure(
    dataset: Dataset,
    config: TrainConfig,
    steps: u32,
    simd: SimdLevel,
    device: Device,
) -> Result<OnGpu, BenchError> {
    let Device::Gpu(gpu) = &device else {
        return Err(BenchError::Device("no GPU was given".to_owned()));
    };
    let (gpu, name) = (gpu.name().to_owned(), dataset.source.clone());
    let mut trainer = Trainer::with_prepass(dataset, config, simd)?;
    trainer.begin_on(device);
    if let Some(why) = trainer.fallback() {
        return Err(BenchError::Device(why));
    }
    let mut run = Run::new(Length::Steps(steps), Instant::now());
    while trainer.steps() < steps / WARM_UP {
        run.step(&mut trainer)?;
    }
    let before = run.summary(&trainer);
    let watched = steps / WATCHED;
    let (begun, first) = (Instant::now(), trainer.steps());
    while trainer.steps() < steps - watched {
        run.step(&mut trainer)?;
    }
    let (seconds, timed) = (begun.elapsed().as_secs_f64(), trainer.steps() - first);
    let after = run.summary(&trainer);
    trainer.watch();
    while !run.is_over(&trainer) {
        run.step(&mut trainer)?;
    }
    if let Some(why) = trainer.fallback() {
        return Err(BenchError::Device(why));
    }
    let kernel = |(name, time): (&'static str, std::time::Duration)| Kernel {
        name,
        microseconds: 1e6 * time.as_secs_f64() / f64::from(watched.max(1)),
    };
    let kernels: Vec<Kernel> = trainer.kernels().into_iter().map(kernel).collect();
    let (rays, samples) = (after.rays - before.rays, after.samples - before.samples);
    Ok(OnGpu {
        gpu,
        dataset: name,
        steps: timed,
        seconds,
        samples_per_second: samples as f64 / seconds,
        samples_per_step: samples as f64 / f64::from(timed.max(1)),
        samples_per_ray: samples as f64 / rays as f64,
        train_psnr: run.summary(&trainer).train_psnr,
        gpu_microseconds: (!kernels.is_empty())
            .then(|| kernels.iter().map(|kernel| kernel.microseconds).sum()),
        kernels,
    })
}

impl fmt::Display for OnGpu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}, training on {}", self.gpu, self.dataset)?;
        writeln!(
            f,
            "{} steps in {:.2} s: {:.1} million samples a second, {:.0} samples a step, {:.1} a \
             ray, PSNR {:.2} dB",
            self.steps,
            self.seconds,
            self.samples_per_second / 1e6,
            self.samples_per_step,
            self.samples_per_ray,
            self.train_psnr
        )?;
        let step = 1e6 * self.seconds / f64::from(self.steps.max(1));
        match self.gpu_microseconds {
            Some(gpu) => writeln!(f, "a step takes {step:.0} us, of which the GPU {gpu:.0} us:")?,
            None => writeln!(f, "a step takes {step:.0} us; the GPU has no timestamps")?,
        }
        for Kernel { name, microseconds } in &self.kernels {
            writeln!(f, "  {name:16} {microseconds:8.1} us")?;
        }
        Ok(())
    }
}
