//! How much a picture may differ from the finest.

use crate::Error;

/// What is left out where it hardly shows: speed against accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Pixels between those that are rendered in any case: 1 (all), 2, 4, 8 or 16.
    pub spacing: u32,
    /// Another pixel is the mean of its neighbours where these differ by less
    /// than this in every premultiplied channel and in opacity, and, where depth is
    /// asked for, by less than this part of it. Neighbours two and more pixels
    /// apart must agree twice, four times, … as well. 0: all are rendered.
    pub tolerance: f32,
    /// A ray ends, and counts as opaque, where less light than this passes, or
    /// less than the model says.
    pub min_transmittance: f32,
}

impl Detail {
    /// Every pixel, as the model says.
    pub const FINEST: Self = Self { spacing: 1, tolerance: 0.0, min_transmittance: 0.0 };

    /// From 0, the fastest, to 1, the finest; the usual is 0.5. Numbers outside
    /// that range, and NaN, count as the nearer end, and as 1.
    #[must_use]
    pub const fn quality(quality: f32) -> Self {
        if quality >= 1.0 || quality.is_nan() {
            return Self::FINEST;
        }
        let left_out = 1.0 - quality.max(0.0);
        Self {
            spacing: 4,
            tolerance: 0.19 * left_out * left_out,
            min_transmittance: 0.16 * left_out * left_out * left_out,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        let fractions = [self.tolerance, self.min_transmittance];
        if !matches!(self.spacing, 1 | 2 | 4 | 8 | 16) {
            return Err(Error::Range("detail: spacing 1, 2, 4, 8 or 16"));
        }
        if !fractions.iter().all(|v| (0.0..1.0).contains(v)) {
            return Err(Error::Range("detail: tolerance and transmittance from 0 to below 1"));
        }
        Ok(())
    }
}

impl Default for Detail {
    fn default() -> Self {
        Self::quality(0.5)
    }
}
