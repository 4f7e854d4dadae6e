//! Times of pictures, measured in rounds. Each model has a turn in every round, so that a
//! disturbance of the machine affects all of them. Before and after each turn, a constant
//! piece of work measures the speed of the machine, which changes by a fifth from minute to
//! minute on shared machines.

use std::time::Instant;

use pocketnerf_baselines::Baseline;
use pocketnerf_core::{Camera, Error, Model};
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::{Painter, Renderer, Settings};

use crate::machine::Pace;

/// Seconds of a turn, if one picture takes less.
const TURN: f64 = 0.25;
/// Pictures of a turn at most.
const PICTURES: usize = 4;
/// Seconds of a picture above which none is needed to warm up the caches.
const LONG: f64 = 0.5;

/// What is rendered, and how.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'m> {
    /// A model.
    Model(&'m Model<'m>, Settings),
    /// A baseline, of which there is one way.
    Baseline(&'m Baseline),
}

impl<'m> Subject<'m> {
    /// What takes its pictures.
    #[must_use]
    pub fn painter(self) -> Box<dyn Painter + 'm> {
        match self {
            Self::Model(model, settings) => Box::new(Renderer::new(model, &settings)),
            Self::Baseline(baseline) => Box::new(pocketnerf_baselines::Renderer::new(baseline)),
        }
    }
}

/// What is rendered one way.
#[derive(Clone, Copy, Debug)]
pub struct Contestant<'m> {
    /// What is rendered.
    pub subject: Subject<'m>,
    /// Cameras, of which the first ones are used.
    pub cameras: &'m [(Camera, Lens)],
    /// Expected seconds of a picture, which decide how many make a turn.
    pub expected: f64,
}

impl Contestant<'_> {
    /// Pictures of a turn.
    fn pictures(&self) -> usize {
        let fit = (TURN / self.expected.max(1e-6)) as usize;
        fit.min(PICTURES).min(self.cameras.len()).max(1)
    }

    /// How long a turn takes, seconds.
    #[must_use]
    pub fn turn(&self) -> f64 {
        let warm_up = usize::from(self.expected <= LONG);
        (self.pictures() + warm_up) as f64 * self.expected
    }

    /// Milliseconds per picture, the mean of a turn.
    fn take_turn(&self) -> Result<f64, Error> {
        let mut painter = self.subject.painter();
        let cameras = &self.cameras[..self.pictures().min(self.cameras.len())];
        if let (true, Some((camera, lens))) = (self.expected <= LONG, cameras.first()) {
            painter.paint(camera, lens)?;
        }
        let begun = Instant::now();
        for (camera, lens) in cameras {
            painter.paint(camera, lens)?;
        }
        Ok(begun.elapsed().as_secs_f64() * 1e3 / cameras.len().max(1) as f64)
    }
}

/// A contestant's turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Milliseconds per picture by the clock.
    pub wall_ms: f64,
    /// How many times longer the constant work took around this turn than at its fastest in
    /// all rounds.
    pub slowdown: f64,
}

impl Turn {
    /// Milliseconds per picture of an undisturbed machine.
    #[must_use]
    pub fn normalized_ms(&self) -> f64 {
        self.wall_ms / self.slowdown
    }
}

/// The turns of every contestant, round after round; every second round in reverse. `done`
/// gets the number of turns so far and returns whether to continue.
///
/// # Errors
/// What rendering reports.
pub fn rounds(
    contestants: &[Contestant<'_>],
    rounds: usize,
    pace: &Pace,
    mut done: impl FnMut(usize) -> bool,
) -> Result<Vec<Vec<Turn>>, Error> {
    let mut turns = vec![Vec::with_capacity(rounds); contestants.len()];
    let (mut n_turns, mut best, mut before) = (0, f64::INFINITY, pace.seconds());
    for round in 0..rounds {
        let n = contestants.len();
        for turn in 0..n {
            let i = if round % 2 == 0 { turn } else { n - 1 - turn };
            let wall_ms = contestants[i].take_turn()?;
            let after = pace.seconds();
            best = best.min(before.min(after));
            turns[i].push(Turn { wall_ms, slowdown: 0.5 * (before + after) });
            before = after;
            n_turns += 1;
            if !done(n_turns) {
                return Ok(turns);
            }
        }
    }
    // Seconds until here.
    turns.iter_mut().flatten().for_each(|turn| turn.slowdown /= best);
    Ok(turns)
}
