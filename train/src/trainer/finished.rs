//! What becomes of a field when it has been trained: a model to be looked at.

use std::borrow::Cow;

use pocketnerf_core::{Error, Model, SimdLevel};

use super::cells::Packed;
use super::occupancy_grid::{FINER_UPDATES, OccupancyGrid};
use super::schedule::frugal;
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
        let [few, some] = [emptier::TILES, tolerance::TILES]
            .map(|tiles| if frugal(&self.config) { tiles / 6 } else { tiles });
        let known = self.known_occupancy();
        let finer = self.finer_occupancy(&known);
        let grid = finer.as_ref().unwrap_or(&known);
        let cells = emptier::needed(grid, &self.model(), &self.trial(few), simd)?;
        let model = Model { occupancy: Some(cells.view()), ..self.model() };
        let tolerance = tolerance::find(&model, &self.trial(some), simd)?;
        Ok(Finished { trainer: self, cells, tolerance })
    }

    /// So many tiles of the training views.
    pub(super) fn trial(&self, tiles: usize) -> Trial<'_> {
        Trial { source: &self.source, aim: &self.aim, seed: self.seed, tiles }
    }

    /// Updates after which a grid is known.
    fn updates(&self) -> usize {
        if frugal(&self.config) { FINER_UPDATES / 2 } else { FINER_UPDATES }
    }

    /// The occupied cells: those that training knows, or, where it has not asked for
    /// them, those that the field fills now.
    fn known_occupancy(&self) -> Cow<'_, OccupancyGrid> {
        if self.config.paper.is_none() {
            return Cow::Borrowed(&self.grid);
        }
        let mut grid = self.grid.clone();
        for _ in 0..self.updates() {
            self.look_at_cells(&mut grid);
        }
        Cow::Owned(grid)
    }

    /// `None` where smaller cells are not to be had, or not worth their bytes.
    fn finer_occupancy(&self, known: &OccupancyGrid) -> Option<OccupancyGrid> {
        if 2 * self.config.occupancy_resolution > MAX_RESOLUTION {
            return None;
        }
        let mut finer = known.finer();
        for _ in 0..self.updates() {
            self.look_at_cells(&mut finer);
        }
        let bytes = |grid: &OccupancyGrid| {
            grid.view().coarse_bytes().len() + grid.view().fine_bytes().len()
        };
        let most = bytes(known) + self.parameters.len() / PARAMETERS_A_BYTE;
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
