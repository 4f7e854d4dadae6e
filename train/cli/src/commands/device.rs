//! What a command renders on.

use std::thread::JoinHandle;

use clap::Args;
use pocketnerf_train::picture::Device;

/// What a command renders on: with the cargo feature `gpu`, an option.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Rendering")]
pub(super) struct DeviceOption {
    /// Device that renders; if no GPU works, the CPU does
    ///
    /// A GPU renders every pixel: --quality says when rays end and how long their last steps
    /// are, and no pixel is interpolated.
    #[cfg(feature = "gpu")]
    #[arg(long, value_enum, value_name = "DEVICE", default_value_t)]
    device: Kind,
}

/// What a run trains on: with the cargo feature `gpu`, an option.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct TrainingDevice {
    /// Device that trains; if no GPU works, the CPU does
    ///
    /// GPUs train hash grids, with eight times as many samples a step. Poses and exposure are
    /// learnt on the CPU alone.
    #[cfg(feature = "gpu")]
    #[arg(long, value_enum, value_name = "DEVICE", default_value_t)]
    device: Kind,
}

/// A device by its name.
#[cfg(feature = "gpu")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Kind {
    #[default]
    Cpu,
    Gpu,
}

impl DeviceOption {
    /// Opens the device; or says why it is the CPU after all.
    #[cfg(feature = "gpu")]
    pub(super) fn open(self) -> (Device, Option<String>) {
        let (device, why) = self.device.open();
        (device, why.map(|why| on_cpu(&why)))
    }

    /// The CPU.
    #[cfg(not(feature = "gpu"))]
    pub(super) fn open(self) -> (Device, Option<String>) {
        (Device::Cpu, None)
    }
}

impl TrainingDevice {
    /// Whether a GPU is to train.
    pub(super) fn is_gpu(self) -> bool {
        #[cfg(feature = "gpu")]
        return self.device == Kind::Gpu;
        #[cfg(not(feature = "gpu"))]
        false
    }

    /// Opens the device; or says why it is the CPU after all.
    #[cfg(feature = "gpu")]
    fn open(self) -> (Device, Option<String>) {
        let (device, why) = self.device.open();
        (device, why.map(|why| trained_on_cpu(&why)))
    }

    /// The CPU.
    #[cfg(not(feature = "gpu"))]
    fn open(self) -> (Device, Option<String>) {
        (Device::Cpu, None)
    }
}

#[cfg(feature = "gpu")]
impl Kind {
    /// The device, or the CPU and why.
    pub(super) fn open(self) -> (Device, Option<String>) {
        use pocketnerf_gpu::{Gpu, Software};

        if self == Self::Cpu {
            return (Device::Cpu, None);
        }
        match Gpu::open(Software::from_environment()) {
            Ok(gpu) => (Device::Gpu(gpu), None),
            Err(why) => (Device::Cpu, Some(why.to_string())),
        }
    }
}

/// A device that is being opened, which takes some drivers a second.
pub(super) struct Opening(Option<JoinHandle<(Device, Option<String>)>>);

impl TrainingDevice {
    /// Opens the device while other things are done.
    pub(super) fn begin_to_open(self) -> Opening {
        Opening(Some(std::thread::spawn(move || self.open())))
    }
}

impl Opening {
    /// The device, and why it is the CPU after all.
    pub(super) fn wait(mut self) -> (Device, Option<String>) {
        let opened = self.0.take().and_then(|thread| thread.join().ok());
        opened.unwrap_or_else(|| (Device::Cpu, Some(trained_on_cpu("the GPU's driver failed"))))
    }
}

impl Drop for Opening {
    /// A program must not end while a driver begins.
    fn drop(&mut self) {
        self.0.take().map(JoinHandle::join);
    }
}

/// What to say where a GPU does not train.
pub(super) fn trained_on_cpu(why: &str) -> String {
    format!("{why}: the CPU trains")
}

/// Prints the GPUs of this machine, the best first.
#[cfg(feature = "gpu")]
pub(super) fn list(common: &super::Common) {
    let gpus = pocketnerf_gpu::adapters();
    if common.json {
        common.print_json(serde_json::json!({ "gpus": gpus }), &[]);
    } else if gpus.is_empty() {
        super::print_line("no GPU was found");
    } else {
        gpus.iter().for_each(super::print_line);
    }
}

/// What to say where a GPU does not render.
pub(super) fn on_cpu(why: &str) -> String {
    format!("{why}: pictures are rendered on the CPU")
}

/// The device's name in JSON: where there was a `fallback`, the CPU's.
pub(super) const fn name(device: &Device, fallback: Option<&str>) -> &'static str {
    match (device, fallback) {
        (Device::Cpu, _) | (_, Some(_)) => "cpu",
        _ => "gpu",
    }
}
