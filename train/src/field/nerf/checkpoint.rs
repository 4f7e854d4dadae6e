//! What a checkpoint adds to the model: section KIND.
//!
//! postcard is positional: the structs here never change.

use pocketnerf_core::field::NerfField;
use pocketnerf_core::march::{Hierarchical, Reach};
use serde::{Deserialize, Serialize};

use super::{NerfConfig, WavesConfig};
use crate::field::{HierarchicalTraining, Unusable};

/// Training by hierarchical sampling.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct HierarchicalV1 {
    n_coarse: u32,
    n_fine: u32,
    clipped: bool,
    noise: f32,
    crop_steps: u32,
}

/// What the model itself does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct NerfV1 {
    hierarchical: Option<HierarchicalV1>,
    muon: bool,
    /// Standard deviations of the random frequencies of positions and directions; 0
    /// where there are none.
    deviations: [f32; 2],
}

impl NerfV1 {
    fn hierarchical(&self) -> Option<HierarchicalTraining> {
        let training = self.hierarchical?;
        let HierarchicalV1 { n_coarse, n_fine, clipped, noise, crop_steps } = training;
        let reach = if clipped { Reach::Clipped } else { Reach::Distance };
        let sampling = Hierarchical { n_coarse, n_fine, reach };
        Some(HierarchicalTraining { sampling, noise, crop_steps })
    }

    /// `None` for bytes that no run has written.
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (nerf, rest) = postcard::take_from_bytes::<Self>(bytes).ok()?;
        let deviations = nerf.deviations.iter().all(|d| (0.0..1e6).contains(d));
        let hierarchical = nerf.hierarchical().is_none_or(|training| {
            training.sampling.validate().is_ok() && (0.0..1e6).contains(&training.noise)
        });
        (rest.is_empty() && deviations && hierarchical).then_some(nerf)
    }
}

impl NerfConfig {
    /// The section.
    pub(super) fn section(&self) -> Vec<u8> {
        let deviation = |waves| match waves {
            Some(WavesConfig::Gaussian { deviation, .. }) => deviation,
            _ => 0.0,
        };
        let hierarchical = self.hierarchical.map(|training| {
            let HierarchicalTraining { sampling, noise, crop_steps } = training;
            let Hierarchical { n_coarse, n_fine, reach } = sampling;
            let clipped = reach == Reach::Clipped;
            HierarchicalV1 { n_coarse, n_fine, clipped, noise, crop_steps }
        });
        let waves = [Some(self.positions.waves), self.directions.map(|d| d.waves)];
        let deviations = waves.map(deviation);
        let nerf = NerfV1 { hierarchical, muon: self.muon, deviations };
        // A vector grows and the structs have a known length: nothing can fail.
        postcard::to_extend(&nerf, Vec::new()).unwrap_or_default()
    }

    /// The shape of a model's field, with what its section adds.
    pub(in crate::field) fn restored(
        field: &NerfField<'_>,
        section: Option<&[u8]>,
    ) -> Result<Self, Unusable> {
        let section = NerfV1::from_bytes(section.ok_or(Unusable::NoSection)?);
        let nerf = section.ok_or(Unusable::Section)?;
        let config =
            Self::of(field, nerf.deviations).ok_or(Unusable::Model("layers that no run has"))?;
        Ok(Self { muon: nerf.muon, hierarchical: nerf.hierarchical(), ..config })
    }
}
