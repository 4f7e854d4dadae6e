//! Occupancy pruning: cells that hold so little that pictures do without them, and cells that are
//! unlike their neighbours and need not be, found on tiles of the training views.
//!
//! Training must sample cells that are nearly empty, to learn what is in them. Once
//! it is over, most of them only cost time; but where a scene is thin, as glass and
//! fog are, they are what it is made of.

use pocketnerf_core::{Error, Model, RenderOptions, SimdLevel, Tuning};

use crate::trainer::finish::calibration_tiles::CalibrationTiles;
use crate::trainer::occupancy::cells::Packed;
use crate::trainer::occupancy::density_grid::DensityGrid;
use crate::trainer::occupancy::smoothing::Neighbours;

/// Optical thickness of a step up to which a cell counts as empty, times that of
/// training. Beyond the last, views that are not tried lose more than those that are
/// (docs/performance.md).
const LADDER: [f32; 9] = [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0];
/// Of the 27 cells around and at one, how many are occupied where it becomes empty, at most, and
/// where it becomes occupied, at least.
const SMOOTHER: [[u8; 2]; 5] = [[3, 22], [5, 20], [7, 18], [9, 16], [12, 15]];
/// Grids that pictures are made with at most: all cells, then halving both ladders.
pub(crate) const MOST_RENDERED: usize = 1 + 4 + 3;
/// Loss that is borne, dB of the training views' PSNR: of cells that are left out, ...
const LOSS: f64 = 0.03;
/// ... and of those that become like their neighbours.
const SMOOTHING_LOSS: f64 = 0.002;
/// Pictures of these may take so many times as many samples: cells that become occupied are sampled.
const LONGER: f64 = 1.02;

/// Calibration tiles, each rendered several times.
pub(crate) const TILES: usize = 24;

/// Finds the cells that pictures need.
pub(crate) struct Pruning<'a> {
    /// Without cells.
    pub(crate) model: &'a Model<'a>,
    pub(crate) tiles: &'a CalibrationTiles<'a>,
    pub(crate) simd: SimdLevel,
}

/// Cells, and what the tiles are with them.
pub(crate) struct Judged {
    pub(crate) cells: Packed,
    /// Sum of squared errors.
    error: f64,
    /// Samples that they take.
    samples: u64,
}

impl Pruning<'_> {
    /// The cells of a `grid` that pictures of the training views need.
    pub(crate) fn needed(&self, grid: &DensityGrid) -> Result<Judged, Error> {
        let all = self.judged(grid.occupied().clone())?;
        let most = all.error * ratio(LOSS);
        let fewer = |threshold: &f32| grid.above(self.model.sampling.step, *threshold);
        self.last(&LADDER, fewer, all, |tried| tried.error <= most)
    }

    /// The same, more like their neighbours: fewer bytes, packed. Only those become occupied that
    /// training samples, whose cells are `known`: it never looked at others.
    pub(crate) fn smoother(&self, needed: Judged, known: &Packed) -> Result<Judged, Error> {
        let wider = needed.cells.view().resolution() / known.view().resolution();
        let is_known = |cell: [u32; 3]| {
            let [x, y, z] = cell.map(|c| c / wider);
            known.view().cell(x, y, z)
        };
        let cells = needed.cells.clone();
        let near = Neighbours::of(&cells);
        let smoother = |[lone, full]: &[u8; 2]| near.smoothed(*lone, *full, is_known);
        let most = needed.error * ratio(SMOOTHING_LOSS);
        let most_samples = (needed.samples as f64 * LONGER) as u64;
        self.last(&SMOOTHER, smoother, needed, |tried| {
            tried.error <= most && tried.samples <= most_samples
        })
    }

    /// Of the cells that the rungs of a ladder make, those of the last that are good, or the `best`
    /// so far: the further up, the worse. Halving finds it.
    fn last<T>(
        &self,
        mut ladder: &[T],
        made: impl Fn(&T) -> Packed,
        mut best: Judged,
        is_good: impl Fn(&Judged) -> bool,
    ) -> Result<Judged, Error> {
        while !ladder.is_empty() {
            let (below, rest) = ladder.split_at(ladder.len() / 2);
            let tried = self.judged(made(&rest[0]))?;
            if is_good(&tried) {
                (best, ladder) = (tried, &rest[1..]);
            } else {
                ladder = below;
            }
        }
        Ok(best)
    }

    fn judged(&self, cells: Packed) -> Result<Judged, Error> {
        let model = Model { occupancy: Some(cells.view()), ..*self.model };
        let options = RenderOptions {
            detail: model.detail(1.0),
            ..RenderOptions::new(&model, self.simd, Tuning::FAST)
        };
        let tiles = self
            .tiles
            .render(&model, &options, |tile| Ok((tile.squared_error(&tile.rgba), tile.samples)))?;
        let error = tiles.iter().map(|(error, _)| error).sum();
        let samples = tiles.iter().map(|(_, samples)| samples).sum();
        Ok(Judged { cells, error, samples })
    }
}

/// Of two errors of which one is so many dB worse.
fn ratio(loss: f64) -> f64 {
    10.0f64.powf(0.1 * loss)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::dataset::Split;
    use crate::trainer::{StepSettings, TrainConfig, Trainer};

    #[test]
    fn what_is_emptied_hardly_shows() {
        let mut config = TrainConfig::hash_grid();
        let grid = &mut config.field.hash_grid_mut().unwrap().grid;
        (grid.n_levels, grid.log2_hashmap_size) = (4, 12);
        config.aabb = Some([[-1.4; 3], [1.4; 3]]);
        (config.samples_per_step, config.occupancy_resolution) = (4096, 64);
        let simd = SimdLevel::detect();
        let mut trainer =
            Trainer::with_prepass(builtin::dataset(Split::Train, 8), config, simd).unwrap();
        let settings = StepSettings { update_occupancy: true, ..StepSettings::PLAIN };
        for _ in 0..200 {
            trainer.step(&settings);
        }
        let mut all = trainer.grid.finer();
        trainer.look(&mut all, 8);
        let (model, tiles) = (trainer.model(), trainer.calibration_tiles(TILES));
        let pruning = Pruning { model: &model, tiles: &tiles, simd };
        let (density, updates) = all.state();
        let (coarse, fine) = (all.view().coarse_bytes(), all.view().fine_bytes());
        // Those that are needed, were all so many times as dense as the field says: as far up the
        // ladder as the loss is borne, and no further.
        let needed = |times: f32| {
            let mut grid = all.clone();
            let density: Vec<f32> = density.iter().map(|density| density * times).collect();
            assert!(grid.restore(&density, updates, coarse, fine));
            let found = pruning.needed(&grid).unwrap();
            let whole = pruning.judged(all.occupied().clone()).unwrap();
            let above = |threshold: &f32| grid.above(model.sampling.step, *threshold);
            let rungs = LADDER.iter().map(|rung| pruning.judged(above(rung)).unwrap());
            let ladder: Vec<_> = std::iter::once(whole).chain(rungs).collect();
            let most = ladder[0].error * ratio(LOSS);
            let is_same = |a: &Packed, b: &Packed| a.view().fine_bytes() == b.view().fine_bytes();
            let at = ladder.iter().rposition(|rung| is_same(&rung.cells, &found.cells)).unwrap();
            assert!(found.error <= most, "{times}: {} {most}", found.error);
            assert!(ladder.get(at + 1).is_none_or(|next| next.error > most), "{times}: {at}");
            found.cells
        };
        let share = |cells: &Packed| cells.view().fraction() / all.view().fraction();
        // Against the photographs, and not only those that were rendered.
        let tiles = CalibrationTiles { seed: tiles.seed + 1, ..tiles };
        let error = |cells: &Packed| {
            let model = Model { occupancy: Some(cells.view()), ..model };
            let options = RenderOptions::new(&model, simd, Tuning::FAST);
            let errors = tiles.render(&model, &options, |t| Ok(t.squared_error(&t.rgba)));
            errors.unwrap().iter().sum::<f64>()
        };
        let whole = error(all.occupied());
        // Even the lowest threshold would empty what shows.
        assert_eq!(share(&needed(1.0 / 9.0)), 1.0);
        // Thresholds of the usual size, so short a time after the start.
        let usual = needed(1.0);
        assert!(share(&usual) >= 0.8, "{}", share(&usual));
        // The highest are little above that of training.
        let denser = needed(9.0);
        assert!((0.8..0.99).contains(&share(&denser)), "{}", share(&denser));
        for some in [usual, denser] {
            let n = all.view().resolution();
            for cell in 0..n * n * n {
                let [x, y, z] = [cell % n, cell / n % n, cell / (n * n)];
                assert!(all.view().cell(x, y, z) || !some.view().cell(x, y, z));
            }
            let emptied = error(&some);
            assert!(emptied < whole * 1.02, "{emptied} {whole}");
        }
    }
}
