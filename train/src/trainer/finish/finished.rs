//! From a trained field to a finished model.

use std::borrow::Cow;

use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Display, Error, Model};

use super::pruning::{Judged, Pruning};
use super::{color_jumps, pruning, tolerance};
use crate::trainer::Trainer;
use crate::trainer::finish::budget::FinishingBudget;
use crate::trainer::finish::calibration_tiles::CalibrationTiles;
use crate::trainer::occupancy::cells::{MOST_CELLS, Packed};
use crate::trainer::occupancy::density_grid::{DensityGrid, PERIOD};
use crate::trainer::run::LONG_ENOUGH;

/// Smaller cells may add a byte to so many parameters, which take a byte or two
/// each.
const PARAMETERS_A_BYTE: usize = 8;

/// Width and height of a tile of which every pixel is costly.
const SMALL_TILE: [u32; 2] = [32, 16];

/// The parts of a finished model that training does without.
#[derive(Debug)]
pub struct Finished<'t> {
    pub(super) trainer: &'t Trainer,
    cells: Packed,
    tolerance: f32,
    /// Views whose photographs are compared with the model's pictures.
    pub(super) views: usize,
}

impl Trainer {
    /// The model as it stands, ready to be rendered: cells become half as wide, so
    /// that fewer samples lie in front of surfaces, unless that would make the file
    /// much larger; the occupied cells that pictures need and the share of a picture that
    /// may be interpolated are then calibrated on tiles of the training views. With
    /// [`FinishingBudget::NONE`] it stays as it stands.
    ///
    /// # Errors
    /// When the SIMD level is not there.
    pub fn finished(&self, budget: FinishingBudget) -> Result<Finished<'_>, Error> {
        if budget == FinishingBudget::NONE {
            let (cells, tolerance) = (self.grid.occupied().clone(), Display::TOLERANCE);
            return Ok(Finished { trainer: self, cells, tolerance, views: 0 });
        }
        let [few, some] = [pruning::TILES, tolerance::TILES].map(|all| budget.tiles(all));
        let mut known = self.seen_once();
        if self.config.hierarchical_training().is_some() {
            self.look_again(known.to_mut(), budget);
        }
        let mut finer = budget.finer.then(|| self.finer_seen_once(&known)).flatten();
        if let Some(finer) = &mut finer {
            self.look_again(finer, budget);
        }
        let grid = finer.as_ref().filter(|finer| self.is_worth(finer, &known)).unwrap_or(&known);
        let (model, tiles, simd) = (self.model(), self.calibration_tiles(few), self.backend.simd());
        let pruning = Pruning { model: &model, tiles: &tiles, simd };
        let Judged { cells, .. } = pruning.smoother(pruning.needed(grid)?, known.occupied())?;
        let cells = if self.hides_much() { self.seen_cells(cells)? } else { cells };
        let model = Model { occupancy: Some(cells.view()), ..model };
        let tolerance = tolerance::find(&model, &self.calibration_tiles(some), simd)?;
        let views = budget.views();
        Ok(Finished { trainer: self, cells, tolerance, views })
    }

    /// Tiles of the training views to calibrate on.
    pub(crate) fn calibration_tiles(&self, tiles: usize) -> CalibrationTiles<'_> {
        let size = if self.config.field.kind().is_costly() { SMALL_TILE } else { Tiles::LARGEST };
        CalibrationTiles {
            source: &self.source,
            visibility: &self.visibility,
            seed: self.seed,
            tiles,
            size,
        }
    }

    /// The occupied cells: those that training knows, or, where it does not sample cells,
    /// those that one sample in each finds.
    pub(crate) fn seen_once(&self) -> Cow<'_, DensityGrid> {
        if self.config.hierarchical_training().is_none() {
            return Cow::Borrowed(&self.grid);
        }
        let mut grid = self.grid.clone();
        self.look(&mut grid, 1);
        Cow::Owned(grid)
    }

    /// Smaller cells, with one sample in each; `None` where there are none, or where they
    /// are not worth their bytes.
    pub(crate) fn finer_seen_once(&self, known: &DensityGrid) -> Option<DensityGrid> {
        if 2 * self.config.occupancy_resolution > MOST_CELLS {
            return None;
        }
        let mut finer = known.finer();
        self.look(&mut finer, 1);
        self.is_worth(&finer, known).then_some(finer)
    }

    /// The other samples in each cell after the first.
    fn look_again(&self, grid: &mut DensityGrid, budget: FinishingBudget) {
        self.look(grid, budget.looks() - 1);
    }

    /// Looks at each cell so many times.
    pub(crate) fn look(&self, grid: &mut DensityGrid, times: usize) {
        for _ in 0..times * PERIOD {
            self.look_at_cells(grid);
        }
        grid.settle(self.sampling.step, self.clearing.factor);
    }

    /// Whether smaller cells are worth their bytes.
    fn is_worth(&self, finer: &DensityGrid, known: &DensityGrid) -> bool {
        let bytes =
            |grid: &DensityGrid| grid.view().coarse_bytes().len() + grid.view().fine_bytes().len();
        bytes(finer) <= bytes(known) + self.backend.parameters().len() / PARAMETERS_A_BYTE
    }
}

impl Finished<'_> {
    /// How much the model risks between the training views, see
    /// [`color_jumps`](crate::trainer::color_jumps); `None` also for a field that is still
    /// taking shape.
    ///
    /// # Errors
    /// Whatever rendering reports.
    pub fn color_jumps(&self) -> Result<Option<f64>, Error> {
        let Trainer { source, seed, backend, step, .. } = self.trainer;
        if *step < LONG_ENOUGH {
            return Ok(None);
        }
        color_jumps::share(&self.model(), source, backend.simd(), *seed)
    }

    /// The model, to be written.
    #[must_use]
    pub fn model(&self) -> Model<'_> {
        let mut model = self.trainer.model();
        model.occupancy = Some(self.cells.view());
        model.display.tolerance = self.tolerance;
        model
    }
}
