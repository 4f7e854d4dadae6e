//! What is said of a run.

use super::guard::Trouble;

/// Where a run stands.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Steps taken.
    pub step: u32,
    /// Steps in all; `None` until they are known.
    pub steps: Option<u32>,
    /// PSNR of the latest rays, dB; 0 before an attempt's first step.
    pub train_psnr: f64,
    /// Mean PSNR of the held-out views when they were last looked at, dB.
    pub held_out_psnr: Option<f64>,
    /// How often training has restarted.
    pub restarts: u32,
    /// Why it has just restarted.
    pub trouble: Option<Trouble>,
}

/// What a run did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Summary {
    /// Rays cast, those of attempts that were given up among them.
    pub rays: u64,
    /// Samples at which the field was evaluated.
    pub samples: u64,
    /// PSNR of the last rays against random backgrounds or the images' own, dB.
    pub train_psnr: f64,
    /// How often training restarted.
    pub restarts: u32,
}
