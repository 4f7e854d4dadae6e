//! How much a finished model is tried out, and how long that takes.

use std::time::Instant;

use pocketnerf_core::{Error, Model, RenderOptions, Tuning};

use super::{pruning, tolerance};
use crate::trainer::{TrainConfig, Trainer};

/// Looks at each cell at most: what none of them finds is empty.
const LOOKS: usize = 8;
/// Looks at each cell at least.
const LEAST_LOOKS: usize = 4;
/// Tiles of a trial at least.
const LEAST_TILES: usize = 4;
/// Tiles that are timed.
const TIMED: usize = 8;
/// Share of a run's time beyond which less is tried.
const SHARE: f64 = 0.03;
/// At least so many seconds are worth it.
const WORTH: f64 = 1.8;
/// What is rehearsed may take so many times as long in the end.
const LATER: f64 = 1.15;

/// How much a finished model is tried out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// The part of all looks and tiles.
    part: f64,
    /// Whether smaller cells are looked at.
    pub(crate) finer: bool,
}

/// To choose from, the best first.
const LADDER: [Effort; 7] = [
    Effort { part: 1.0, finer: true },
    Effort { part: 0.7, finer: true },
    Effort { part: 0.5, finer: true },
    Effort { part: 0.3, finer: true },
    Effort { part: 0.2, finer: true },
    Effort { part: 0.5, finer: false },
    Effort { part: 0.2, finer: false },
];

impl Effort {
    /// Where time is no matter: all, or half with networks, which take a thousand times as
    /// long as a grid.
    #[must_use]
    pub fn usual(config: &TrainConfig) -> Self {
        Self { part: if config.field.kind().is_costly() { 0.5 } else { 1.0 }, finer: true }
    }

    /// Looks at each cell.
    pub(crate) fn looks(self) -> usize {
        ((self.part * LOOKS as f64).round() as usize).clamp(LEAST_LOOKS, LOOKS)
    }

    /// So many tiles, where `all` would be tried with all effort.
    pub(crate) fn tiles(self, all: usize) -> usize {
        ((self.part * all as f64).ceil() as usize).max(LEAST_TILES)
    }
}

/// What trying a model out takes, seconds.
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
}

impl Costs {
    /// As much effort as a run of so many seconds leaves time for, and how long that takes.
    pub(crate) fn effort(&self, seconds: f64) -> (Effort, f64) {
        let most = (SHARE * seconds).max(WORTH);
        let tried = LADDER.map(|effort| (effort, self.seconds(effort)));
        let affordable = tried.into_iter().find(|(_, seconds)| *seconds <= most);
        affordable.unwrap_or(tried[LADDER.len() - 1])
    }

    fn seconds(&self, effort: Effort) -> f64 {
        let looks = effort.looks() as f64;
        let finer = match (effort.finer, self.given_up) {
            (false, _) => 0.0,
            (true, true) => self.finer,
            (true, false) => looks * self.finer,
        };
        let cells = effort.tiles(pruning::TILES) * pruning::MOST_RENDERED;
        let tiles = (cells + effort.tiles(tolerance::TILES)) as f64;
        LATER * (looks * self.look + finer + tiles * self.tile)
    }
}

impl Trainer {
    /// Finds out what [`Trainer::finished`] would take now, by doing a small part of it.
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
        self.trial(TIMED).render(&model, &options, |_| Ok(()))?;
        let tile = clock.elapsed().as_secs_f64() / TIMED as f64;
        Ok(Costs { look, finer, given_up: seen.is_none(), tile })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_dear_is_tried_less() {
        let costs = Costs { look: 0.0, finer: 0.1, given_up: false, tile: 0.005 };
        // 8 looks, 24 tiles five times and 48 once: 0.8 + 0.84 seconds, and a little more.
        let (effort, seconds) = costs.effort(100.0);
        assert_eq!((effort, effort.looks(), effort.tiles(24)), (LADDER[0], 8, 24));
        assert!((seconds - 1.15 * 1.64).abs() < 1e-9, "{seconds}");
        // Ten times as dear, three seconds for it: four looks alone are 4.
        let dear = Costs { finer: 1.0, tile: 0.05, ..costs };
        let (effort, seconds) = dear.effort(100.0);
        assert_eq!((effort.finer, effort.tiles(24)), (false, 5));
        assert!((seconds - 1.15 * 0.05 * 35.0).abs() < 1e-9, "{seconds}");
        // One look shows that they are too many.
        let (effort, _) = Costs { given_up: true, tile: 0.005, ..dear }.effort(100.0);
        assert_eq!(effort, LADDER[0]);
        // More than there is time for: the least.
        assert_eq!(Costs { tile: 9.0, ..costs }.effort(100.0).0, LADDER[6]);
    }
}
