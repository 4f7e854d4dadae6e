//! What becomes of a field when it has been trained: a model to be looked at.

use std::borrow::Cow;

use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Error, Model};

use super::{pruning, tolerance};
use crate::trainer::Trainer;
use crate::trainer::finish::budget::Effort;
use crate::trainer::finish::calibration_tiles::Trial;
use crate::trainer::occupancy::cells::Packed;
use crate::trainer::occupancy::density_grid::{OccupancyGrid, PERIOD};

/// Cells along an axis at most: the format's limit.
const MAX_RESOLUTION: u32 = 512;

/// Smaller cells may add a byte to so many parameters, which take a byte or two
/// each.
const PARAMETERS_A_BYTE: usize = 8;

/// Width and height of a tile of which every pixel is costly.
const SMALL_TILE: [u32; 2] = [32, 16];

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
    pub fn finished(&self, effort: Effort) -> Result<Finished<'_>, Error> {
        let [few, some] = [pruning::TILES, tolerance::TILES].map(|all| effort.tiles(all));
        let mut known = self.seen_once();
        if self.config.hierarchical_training().is_some() {
            self.look_again(known.to_mut(), effort);
        }
        let mut finer = effort.finer.then(|| self.finer_seen_once(&known)).flatten();
        if let Some(finer) = &mut finer {
            self.look_again(finer, effort);
        }
        let grid = finer.as_ref().filter(|finer| self.is_worth(finer, &known)).unwrap_or(&known);
        let cells = pruning::needed(grid, &self.model(), &self.trial(few), self.backend.simd())?;
        let model = Model { occupancy: Some(cells.view()), ..self.model() };
        let tolerance = tolerance::find(&model, &self.trial(some), self.backend.simd())?;
        Ok(Finished { trainer: self, cells, tolerance })
    }

    /// So many tiles of the training views.
    pub(crate) fn trial(&self, tiles: usize) -> Trial<'_> {
        let size = if self.config.field.kind().is_costly() { SMALL_TILE } else { Tiles::LARGEST };
        Trial { source: &self.source, aim: &self.aim, seed: self.seed, tiles, size }
    }

    /// The occupied cells: those that training knows, or, where it has not asked for
    /// them, those that a look at each finds.
    pub(crate) fn seen_once(&self) -> Cow<'_, OccupancyGrid> {
        if self.config.hierarchical_training().is_none() {
            return Cow::Borrowed(&self.grid);
        }
        let mut grid = self.grid.clone();
        self.look(&mut grid, 1);
        Cow::Owned(grid)
    }

    /// Smaller cells, each looked at once; `None` where they are not to be had, or not
    /// worth their bytes.
    pub(crate) fn finer_seen_once(&self, known: &OccupancyGrid) -> Option<OccupancyGrid> {
        if 2 * self.config.occupancy_resolution > MAX_RESOLUTION {
            return None;
        }
        let mut finer = known.finer();
        self.look(&mut finer, 1);
        self.is_worth(&finer, known).then_some(finer)
    }

    /// The looks at each cell that are left after the first.
    fn look_again(&self, grid: &mut OccupancyGrid, effort: Effort) {
        self.look(grid, effort.looks() - 1);
    }

    /// Looks at each cell so many times.
    pub(crate) fn look(&self, grid: &mut OccupancyGrid, times: usize) {
        for _ in 0..times * PERIOD {
            self.look_at_cells(grid);
        }
        grid.settle(self.sampling.step);
    }

    /// Whether smaller cells are worth their bytes.
    fn is_worth(&self, finer: &OccupancyGrid, known: &OccupancyGrid) -> bool {
        let bytes = |grid: &OccupancyGrid| {
            grid.view().coarse_bytes().len() + grid.view().fine_bytes().len()
        };
        bytes(finer)
            <= bytes(known) + self.backend.download().field().parameters.len() / PARAMETERS_A_BYTE
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
