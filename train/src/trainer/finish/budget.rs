//! The finishing budget: how much of calibration a run has time for.

use std::time::Instant;

use pocketnerf_core::{Error, Model, RenderOptions, Tuning};

use super::{photos, pruning, tolerance};
use crate::trainer::{TrainConfig, Trainer};

/// Looks at each cell at most: what none of them finds is empty.
const LOOKS: usize = 8;
/// Looks at each cell at least.
const LEAST_LOOKS: usize = 4;
/// Calibration tiles at least.
const LEAST_TILES: usize = 4;
/// Tiles that are timed.
const TIMED: usize = 8;
/// Share of a run's time that finishing may take.
const SHARE: f64 = 0.03;
/// At least so many seconds are worth it.
const WORTH: f64 = 1.8;
/// On a GPU, where a second is worth more steps: this share of the run, if that is less. Then no
/// smaller cells are tried, whose time is not told well enough for runs that short.
const SHARE_ON_GPU: f64 = 0.1;
/// Without a time limit, all tiles are rendered after so many times the steps in which a field takes
/// shape, a share of them before: a run is not to finish for longer than it trains.
const ALL_AFTER: u32 = 2;
/// This share at least.
const LEAST_PART: f64 = 0.2;
/// What is rehearsed may take so many times as long in the end.
const LATER: f64 = 1.15;

/// How much a finished model is calibrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinishingBudget {
    /// Share of all density samples, and of all photographs that are looked at.
    part: f64,
    /// Share of all calibration tiles.
    tiled: f64,
    /// Whether smaller cells are tried.
    pub(crate) finer: bool,
}

/// The choices, best first.
const LADDER: [FinishingBudget; 7] = [
    FinishingBudget::of(1.0, true),
    FinishingBudget::of(0.7, true),
    FinishingBudget::of(0.5, true),
    FinishingBudget::of(0.3, true),
    FinishingBudget::of(0.2, true),
    FinishingBudget::of(0.5, false),
    FinishingBudget::of(0.2, false),
];

impl FinishingBudget {
    /// Nothing is calibrated: cells and tolerance stay as training has them.
    pub const NONE: Self = Self::of(0.0, false);

    const fn of(part: f64, finer: bool) -> Self {
        Self { part, tiled: part, finer }
    }

    /// Without a time limit, after so many steps: all, or half for a costly field; fewer tiles where
    /// steps are few. Fewer density samples would empty cells that show.
    #[must_use]
    pub fn usual(config: &TrainConfig, steps: u32) -> Self {
        let most = if config.field.kind().is_costly() { 0.5 } else { 1.0 };
        let learnt = f64::from(steps) / f64::from(ALL_AFTER * config.settled());
        Self { tiled: most * learnt.clamp(LEAST_PART, 1.0), ..Self::of(most, true) }
    }

    /// Looks at each cell.
    pub(crate) fn looks(self) -> usize {
        ((self.part * LOOKS as f64).round() as usize).clamp(LEAST_LOOKS, LOOKS)
    }

    /// The number of tiles, where a full budget has `all`.
    pub(crate) fn tiles(self, all: usize) -> usize {
        some(self.tiled, all)
    }

    /// The number of photographs that are looked at: as many as say something, or none.
    pub(crate) fn views(self) -> usize {
        if self == Self::NONE { 0 } else { some(self.part, photos::VIEWS).max(photos::FEWEST) }
    }
}

fn some(part: f64, all: usize) -> usize {
    ((part * all as f64).ceil() as usize).max(LEAST_TILES)
}

/// What calibrating a model costs, seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Costs {
    /// A look at every cell.
    look: f64,
    /// A look at every smaller cell.
    finer: f64,
    /// Whether a look says that smaller cells are not worth more.
    given_up: bool,
    /// A tile.
    tile: f64,
    /// Which cells photographs see, where that is asked.
    seen: f64,
}

impl Costs {
    /// The largest budget that fits a run of so many seconds on a GPU or the CPU, and what it takes;
    /// none where even the smallest would take too long.
    pub(crate) fn budget(&self, seconds: f64, on_gpu: bool) -> (FinishingBudget, f64) {
        let worth = if on_gpu { WORTH.min(SHARE_ON_GPU * seconds) } else { WORTH };
        let most = (SHARE * seconds).max(worth);
        let costs = LADDER.map(|budget| (budget, self.seconds(budget)));
        let affordable = costs
            .into_iter()
            .find(|(budget, seconds)| *seconds <= most && (worth == WORTH || !budget.finer));
        affordable.unwrap_or((FinishingBudget::NONE, 0.0))
    }

    fn seconds(&self, budget: FinishingBudget) -> f64 {
        let looks = budget.looks() as f64;
        let finer = match (budget.finer, self.given_up) {
            (false, _) => 0.0,
            (true, true) => self.finer,
            (true, false) => looks * self.finer,
        };
        let cells = budget.tiles(pruning::TILES) * pruning::MOST_RENDERED;
        let looked_at = photos::TILES * budget.views();
        let tiles = (cells + budget.tiles(tolerance::TILES) + looked_at) as f64;
        LATER * (looks * self.look + finer + tiles * self.tile + self.seen)
    }
}

impl Trainer {
    /// Estimates what [`Trainer::finished`] would cost now, by doing a small part of it.
    ///
    /// # Errors
    /// When the SIMD level is not there.
    pub(crate) fn rehearse(&self) -> Result<Costs, Error> {
        let clock = Instant::now();
        let known = self.seen_once();
        let look = clock.elapsed().as_secs_f64();
        let seen = self.finer_seen_once(&known);
        let finer = clock.elapsed().as_secs_f64() - look;
        let grid = seen.as_ref().unwrap_or(&known);
        let model = Model { occupancy: Some(grid.view()), ..self.model() };
        let detail = model.detail(1.0);
        let options = RenderOptions {
            detail,
            ..RenderOptions::new(&model, self.backend.simd(), Tuning::FAST)
        };
        let clock = Instant::now();
        self.calibration_tiles(TIMED).render(&model, &options, |_| Ok(()))?;
        let tile = clock.elapsed().as_secs_f64() / TIMED as f64;
        let unseen = self.rehearse_seen_cells(grid.occupied())?;
        Ok(Costs { look, finer, given_up: seen.is_none(), tile, seen: unseen })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_steps_are_calibrated_on_fewer_tiles() {
        let usual = |steps| FinishingBudget::usual(&TrainConfig::hash_grid(), steps);
        let [least, some, all] = [0, 512, 1024].map(usual);
        assert_eq!((least.looks(), least.tiles(24), least.finer), (8, 5, true));
        assert_eq!((some.looks(), some.tiles(24)), (8, 12));
        assert_eq!((all, usual(99_999)), (LADDER[0], LADDER[0]));
        assert_eq!([least, some, all].map(FinishingBudget::views), [32; 3]);
        // A costly field takes shape in 100 steps, and is calibrated half as much.
        let costly = |steps| FinishingBudget::usual(&TrainConfig::nerf(), steps);
        assert_eq!([100, 200].map(|steps| costly(steps).tiles(24)), [6, 12]);
    }

    #[test]
    fn what_is_costly_is_tried_less() {
        let costs = Costs { look: 0.0, finer: 0.1, given_up: false, tile: 0.005, seen: 0.0 };
        // 8 looks, 24 tiles eight times, 48 once, two of each of 32 views: 0.8 + 1.52 seconds, and a
        // little more.
        let (budget, seconds) = costs.budget(100.0, false);
        assert_eq!((budget, budget.looks(), budget.tiles(24)), (LADDER[0], 8, 24));
        assert!((seconds - 1.15 * 2.32).abs() < 1e-9, "{seconds}");
        // Six seconds on the CPU leave time for half of the tiles: 0.4 + 0.76 s; on a GPU for the least.
        assert_eq!(costs.budget(6.0, false).0, LADDER[2]);
        assert_eq!(costs.budget(6.0, true).0, LADDER[6]);
        // Ten seconds there would be enough for smaller cells, which are tried from 18 on.
        assert_eq!(costs.budget(10.0, true).0, LADDER[5]);
        assert_eq!(costs.budget(18.0, true).0, LADDER[2]);
        // 0.9 seconds for what photographs see, and 1.9 for the rest: less is calibrated.
        let (budget, seconds) = Costs { seen: 0.9, ..costs }.budget(100.0, false);
        assert_eq!(budget, LADDER[1]);
        // 6 looks, 17 tiles eight times, 34 once, two of each of 23 views.
        assert!((seconds - 1.15 * (0.9 + 0.6 + 0.005 * 216.0)).abs() < 1e-9, "{seconds}");
        // Ten times as costly, three seconds for it: four looks alone are 4.
        let costly = Costs { finer: 1.0, tile: 0.035, ..costs };
        let (budget, seconds) = costly.budget(100.0, false);
        assert_eq!((budget.finer, budget.tiles(24)), (false, 5));
        // 40 and 10 tiles, and two of each of 8 views.
        assert_eq!((budget.views(), FinishingBudget::NONE.views()), (8, 0));
        assert!((seconds - 1.15 * 0.035 * 66.0).abs() < 1e-9, "{seconds}");
        // One look shows that they are too many.
        let (budget, _) = Costs { given_up: true, tile: 0.005, ..costly }.budget(100.0, false);
        assert_eq!(budget, LADDER[0]);
        // The least still takes longer than there is time for: nothing. 66 tiles, 3 s.
        let least = Costs { look: 0.3, finer: 9.0, tile: 0.021, ..costs };
        assert_eq!(least.budget(100.0, false).0, LADDER[6]);
        let most = (FinishingBudget::NONE, 0.0);
        assert_eq!(Costs { tile: 0.09, ..least }.budget(100.0, false), most);
        assert_eq!(Costs { tile: 9.0, ..costs }.budget(100.0, false), most);
    }
}
