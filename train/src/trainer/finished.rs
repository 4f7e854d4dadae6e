//! What becomes of a field when it has been trained: a model to be looked at.

use pocketnerf_core::{Error, Model, SimdLevel};

use super::cells::Packed;
use super::occupancy_grid::{FINER_UPDATES, OccupancyGrid};
use super::trial::Trial;
use super::{Trainer, emptier, tolerance};

/// Cells along an axis at most: the format's limit.
const MAX_RESOLUTION: u32 = 512;

/// Smaller cells may add a byte to so many parameters, which take a byte or two
/// each.
const PARAMETERS_A_BYTE: usize = 8;

/// The parts of a finished model that training does without.
#[derive(Debug)]
pub struct Finished<'t> {
    trainer: &'t Trainer,
    cells: Packed,
    tolerance: f32,
}

impl Trainer {
    /// The model as it stands, ready to be rendered: cells become half as wide, so
    /// that fewer samples lie in front of surfaces, unless that would make the file
    /// much larger; and it is tried which of them pictures need, and how much of a
    /// picture may be interpolated.
    ///
    /// # Errors
    /// When the SIMD level is not there.
    pub fn finished(&self, simd: SimdLevel) -> Result<Finished<'_>, Error> {
        let finer = self.finer_occupancy();
        let grid = finer.as_ref().unwrap_or(&self.grid);
        let cells = emptier::needed(grid, &self.model(), &self.trial(emptier::TILES), simd)?;
        let model = Model { occupancy: Some(cells.view()), ..self.model() };
        let tolerance = tolerance::find(&model, &self.trial(tolerance::TILES), simd)?;
        Ok(Finished { trainer: self, cells, tolerance })
    }

    /// So many tiles of the training views.
    pub(super) fn trial(&self, tiles: usize) -> Trial<'_> {
        Trial { source: &self.source, aim: &self.aim, seed: self.seed, tiles }
    }

    /// `None` where smaller cells are not to be had, or not worth their bytes.
    fn finer_occupancy(&self) -> Option<OccupancyGrid> {
        if 2 * self.config.occupancy_resolution > MAX_RESOLUTION {
            return None;
        }
        let mut finer = self.grid.finer();
        for _ in 0..FINER_UPDATES {
            self.look_at_cells(&mut finer);
        }
        let bytes = |grid: &OccupancyGrid| {
            grid.view().coarse_bytes().len() + grid.view().fine_bytes().len()
        };
        let most = bytes(&self.grid) + self.parameters.len() / PARAMETERS_A_BYTE;
        (bytes(&finer) <= most).then_some(finer)
    }
}

impl Finished<'_> {
    /// The model, to be written.
    #[must_use]
    pub fn model(&self) -> Model<'_> {
        let mut model = self.trainer.model();
        model.occupancy = Some(self.cells.view());
        model.display.tolerance = self.tolerance;
        model
    }
}
