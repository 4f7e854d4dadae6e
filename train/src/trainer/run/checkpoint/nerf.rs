//! Section NERF: what a run of the paper's field needs beside what all have.
//!
//! postcard is positional: the structs here never change.

use pocketnerf_core::march::{Hierarchical, Reach};
use serde::{Deserialize, Serialize};

use crate::field::WavesConfig;
use crate::trainer::TrainConfig;
use crate::trainer::config::Paper;

/// The paper's way to train.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct PaperV1 {
    n_coarse: u32,
    n_fine: u32,
    clipped: bool,
    noise: f32,
    crop_steps: u32,
}

/// What the model itself does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct NerfV1 {
    paper: Option<PaperV1>,
    pub(super) orthogonal: bool,
    /// Standard deviations of the random frequencies of positions and directions; 0
    /// where there are none.
    pub(super) deviations: [f32; 2],
}

impl NerfV1 {
    /// `None` for another field.
    pub(super) fn of(config: &TrainConfig) -> Option<Self> {
        let nerf = config.nerf_field()?;
        let deviation = |waves| match waves {
            Some(WavesConfig::Gaussian { deviation, .. }) => deviation,
            _ => 0.0,
        };
        let paper = config.paper.map(|Paper { sampling, noise, crop_steps }| {
            let Hierarchical { n_coarse, n_fine, reach } = sampling;
            let clipped = reach == Reach::Clipped;
            PaperV1 { n_coarse, n_fine, clipped, noise, crop_steps }
        });
        let waves = [Some(nerf.positions.waves), nerf.directions.map(|d| d.waves)];
        Some(Self { paper, orthogonal: config.orthogonal, deviations: waves.map(deviation) })
    }

    pub(super) fn paper(&self) -> Option<Paper> {
        self.paper.map(|PaperV1 { n_coarse, n_fine, clipped, noise, crop_steps }| Paper {
            sampling: Hierarchical {
                n_coarse,
                n_fine,
                reach: if clipped { Reach::Clipped } else { Reach::Distance },
            },
            noise,
            crop_steps,
        })
    }

    pub(super) fn to_bytes(self) -> Vec<u8> {
        // A vector grows and the structs have a known length: nothing can fail.
        postcard::to_extend(&self, Vec::new()).unwrap_or_default()
    }

    /// `None` for bytes that no run has written.
    pub(super) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (nerf, rest) = postcard::take_from_bytes::<Self>(bytes).ok()?;
        let deviations = nerf.deviations.iter().all(|d| (0.0..1e6).contains(d));
        let paper = nerf.paper().is_none_or(|paper| {
            paper.sampling.validate().is_ok() && (0.0..1e6).contains(&paper.noise)
        });
        (rest.is_empty() && deviations && paper).then_some(nerf)
    }
}
