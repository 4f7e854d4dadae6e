//! How much a picture may differ from the finest.

use crate::Error;

/// What is left out where it hardly shows: speed against accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// A pixel is the mean of its neighbours, 1, 2, 4 or 8 pixels away, where
    /// these differ by less than this in every premultiplied channel and in opacity
    /// (the means of those that face each other by a third of it) and, where depth
    /// is rendered, by less than this part of it. 0: pixels that need neighbours
    /// so far away are all rendered.
    pub tolerances: [f32; 4],
    /// A ray ends, and counts as opaque, where less light than this passes, or
    /// less than the model says.
    pub min_transmittance: f32,
    /// Where less light than this passes, a ray's samples stand for two steps;
    /// where less than a quarter of it does, for four. 0: each for its own.
    pub coarse_step_below: f32,
    /// Whether networks may round to 14 bits where that is faster: on x86, and where rays are
    /// marched. Colours change by less than a thousandth.
    pub rounded: bool,
}

impl Detail {
    /// Every pixel, as the model says.
    pub const FINEST: Self = Self {
        tolerances: [0.0; 4],
        min_transmittance: 0.0,
        coarse_step_below: 0.0,
        rounded: false,
    };

    /// See [`Model::detail`](crate::Model::detail).
    pub(crate) fn new(quality: f32, tolerance: f32) -> Self {
        if quality >= 1.0 || quality.is_nan() {
            return Self::FINEST;
        }
        // From 0 to 2; 1 is usual.
        let left_out = 2.0 * (1.0 - quality.max(0.0));
        // Farther neighbours agree by chance more often.
        let far = (left_out - 1.0).max(0.0);
        Self {
            tolerances: [tolerance * left_out * left_out, tolerance * far * far, 0.0, 0.0],
            min_transmittance: 0.02 * left_out * left_out * left_out,
            coarse_step_below: 0.3 * left_out.min(1.0),
            rounded: true,
        }
    }

    /// Pixels between those that are rendered in any case.
    pub(crate) fn spacing(&self) -> u32 {
        let levels = self.tolerances.iter().rposition(|tolerance| *tolerance > 0.0);
        levels.map_or(1, |level| 2 << level)
    }

    /// The tolerance of pixels whose neighbours are `half` pixels away, a power
    /// of two.
    pub(crate) fn tolerance(&self, half: u32) -> f32 {
        self.tolerances.get(half.trailing_zeros() as usize).copied().unwrap_or(0.0)
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        let mut fractions =
            self.tolerances.iter().chain([&self.min_transmittance, &self.coarse_step_below]);
        if !fractions.all(|v| (0.0..1.0).contains(v)) {
            return Err(Error::Range(
                "detail: tolerances, min_transmittance and coarse_step_below, from 0 to below 1",
            ));
        }
        Ok(())
    }
}
