//! The shape of planes and lines, and when they become finer.

use pocketnerf_core::Error;
use pocketnerf_core::encoding::planes::{FEATURES, RESOLUTIONS};
use pocketnerf_core::field::PlanesField;

use super::PlanesFieldConfig;
use crate::field::Unusable;

/// Shares of a run after which planes are finer than before.
const FINER_FROM: [f32; 3] = [0.04, 0.1, 0.2];
/// The fewest entries along an axis that training begins with, unless it ends with fewer.
const FEWEST: f32 = 96.0;
/// The fewest and the most entries along an axis that photographs are given by their pixels.
const BY_PIXELS: [f32; 2] = [32.0, 300.0];

/// Planes and lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanesConfig {
    /// Entries along an axis now.
    pub resolution: u32,
    /// In the end.
    pub last_resolution: u32,
    /// Products along each axis: 16 or 32.
    pub n_components: u32,
}

impl PlanesConfig {
    /// Planes that end with so many entries along an axis, and begin with as few as 96.
    #[must_use]
    pub fn new(last_resolution: u32, n_components: u32) -> Self {
        let mut planes = Self { resolution: 0, last_resolution, n_components };
        planes.resolution = planes.resolution_at(0.0);
        planes
    }

    /// Entries along an axis in the end for photographs of so many pixels across: one a pixel, up
    /// to 300. Between more there is nothing to learn from, and noise is learnt instead.
    #[must_use]
    pub fn resolution_for(pixels: f32) -> u32 {
        let [fewest, most] = BY_PIXELS;
        pixels.clamp(fewest, most).round() as u32
    }

    /// Entries along an axis when so much of a run is over: steps of equal ratios, as in the
    /// paper (Chen et al. 2022).
    fn resolution_at(&self, progress: f32) -> u32 {
        let last = self.last_resolution as f32;
        let steps_left = FINER_FROM.iter().filter(|from| progress < **from).count();
        let share = steps_left as f32 / FINER_FROM.len() as f32;
        let resolution = last * (FEWEST.min(last) / last).powf(share);
        resolution.round() as u32
    }

    /// What they are to be when so much of a run is over, if that is finer than they are.
    pub(super) fn finer(&self, progress: f32) -> Option<Self> {
        let resolution = self.resolution_at(progress);
        (resolution > self.resolution).then_some(Self { resolution, ..*self })
    }

    /// Shapes of the tables of a pair: the plane's, the line's.
    pub(super) const fn pair(&self) -> [[usize; 2]; 2] {
        let n = self.resolution as usize;
        [[n * n, FEATURES], [n, FEATURES]]
    }

    /// What a checkpoint holds.
    pub(super) fn section(&self) -> Vec<u8> {
        self.last_resolution.to_le_bytes().to_vec()
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        let sound = |n| RESOLUTIONS.contains(&n);
        if !sound(self.resolution) || !sound(self.last_resolution) {
            return Err(Error::Range("planes: resolution, from 2 to 2048"));
        }
        if !matches!(self.n_components, 16 | 32) {
            return Err(Error::Range("planes: components, 16 or 32"));
        }
        Ok(())
    }
}

impl PlanesFieldConfig {
    /// The shape of a model's field, with what a checkpoint adds to it.
    pub(in crate::field) fn restored(
        field: &PlanesField<'_>,
        section: Option<&[u8]>,
    ) -> Result<Self, Unusable> {
        let section = section.ok_or(Unusable::NoSection)?;
        let last = <[u8; 4]>::try_from(section).map_err(|_| Unusable::Section)?;
        let (resolution, n_components) = (field.planes.resolution, field.planes.n_components);
        let last_resolution = u32::from_le_bytes(last);
        let grid = PlanesConfig { resolution, last_resolution, n_components };
        grid.check().map_err(|_| Unusable::Section)?;
        Ok(Self::with(grid, &field.decoder))
    }
}
