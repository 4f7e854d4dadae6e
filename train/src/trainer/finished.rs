//! What becomes of a field when it has been trained: a model to be looked at.

use pocketnerf_core::{Error, Model, SimdLevel};

use super::occupancy_grid::{FINER_UPDATES, OccupancyGrid};
use super::{Trainer, tolerance};

/// Cells along an axis at most: the format's limit.
const MAX_RESOLUTION: u32 = 512;

/// The parts of a finished model that training does without.
#[derive(Debug)]
pub struct Finished<'t> {
    trainer: &'t Trainer,
    occupancy: OccupancyGrid,
    tolerance: f32,
}

impl Trainer {
    /// The model as it stands, ready to be rendered: occupied cells are halved
    /// where one half is empty, so that fewer samples lie in front of surfaces, and it
    /// is tried how much of a picture may be interpolated.
    ///
    /// # Errors
    /// When the SIMD level is not there.
    pub fn finished(&self, simd: SimdLevel) -> Result<Finished<'_>, Error> {
        let mut occupancy = self.grid.clone();
        if 2 * self.config.occupancy_resolution <= MAX_RESOLUTION {
            occupancy = occupancy.finer();
            for _ in 0..FINER_UPDATES {
                self.look_at_cells(&mut occupancy);
            }
        }
        let model = Model { occupancy: Some(occupancy.view()), ..self.model() };
        let tolerance = tolerance::find(&model, &self.source, self.seed, simd)?;
        Ok(Finished { trainer: self, occupancy, tolerance })
    }
}

impl Finished<'_> {
    /// The model, to be written.
    #[must_use]
    pub fn model(&self) -> Model<'_> {
        let mut model = self.trainer.model();
        model.occupancy = Some(self.occupancy.view());
        model.display.tolerance = self.tolerance;
        model
    }
}
