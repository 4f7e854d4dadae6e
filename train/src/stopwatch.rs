//! How long the stages of rendering and training take, over all threads.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A stage of rendering or training.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Rendering: pixels that are the mean of their neighbours.
    Interpolate,
    /// Rendering: rays, and their way to the first occupied cell.
    Camera,
    /// Training: random pixels, their colours and rays.
    Pixels,
    /// The next occupied samples of the rays; in training, entering the box too.
    March,
    /// Positions to numbers.
    Encode,
    /// The density network forwards.
    Density,
    /// Densities to opacities, and the rays' sums.
    Composite,
    /// Rendering: the colour network and the pixels.
    Color,
    /// Training: the colour network forwards and backwards, the loss, the roulette.
    Shade,
    /// Training: positions of the samples that are passed back to numbers again.
    EncodeAgain,
    /// Training: the density network's hidden layers again, and all of it backwards.
    Backward,
    /// Training: gradients to the grid's entries.
    Scatter,
    /// Training: the groups' network gradients to one.
    Reduce,
    /// Training: the new parameters, and their rounding to half precision.
    Adam,
    /// Training: densities of cells, and the bits made from them.
    Occupancy,
}

impl Stage {
    const COUNT: usize = Self::Occupancy as usize + 1;
}

/// Time and units of work of one stage.
#[derive(Debug, Default)]
struct Total {
    nanoseconds: AtomicU64,
    units: AtomicU64,
}

/// Sums up the time that threads spend in each stage.
#[derive(Debug, Default)]
pub struct Stopwatch([Total; Stage::COUNT]);

impl Stopwatch {
    /// Adds to a stage. What a unit is depends on the stage: a ray, a sample.
    pub fn add(&self, stage: Stage, time: Duration, units: usize) {
        let total = &self.0[stage as usize];
        total.nanoseconds.fetch_add(time.as_nanos() as u64, Ordering::Relaxed);
        total.units.fetch_add(units as u64, Ordering::Relaxed);
    }

    /// Seconds of a stage, all threads together.
    pub fn seconds(&self, stage: Stage) -> f64 {
        self.0[stage as usize].nanoseconds.load(Ordering::Relaxed) as f64 * 1e-9
    }

    /// Units of a stage.
    pub fn units(&self, stage: Stage) -> u64 {
        self.0[stage as usize].units.load(Ordering::Relaxed)
    }
}

/// The laps of one thread: what passes between two belongs to the later one's
/// stage. Without a stopwatch they cost nothing.
#[derive(Debug)]
pub struct Laps<'w>(Option<(&'w Stopwatch, Instant)>);

impl<'w> Laps<'w> {
    /// The first lap begins now.
    pub fn begin(stopwatch: Option<&'w Stopwatch>) -> Self {
        Self(stopwatch.map(|stopwatch| (stopwatch, Instant::now())))
    }

    /// A lap ends, the next begins.
    pub fn end(&mut self, stage: Stage, units: usize) {
        if let Some((stopwatch, begun)) = &mut self.0 {
            let now = Instant::now();
            stopwatch.add(stage, now - *begun, units);
            *begun = now;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laps_share_out_the_time() {
        let stopwatch = Stopwatch::default();
        let begun = Instant::now();
        let mut laps = Laps::begin(Some(&stopwatch));
        std::thread::sleep(Duration::from_millis(2));
        laps.end(Stage::March, 5);
        laps.end(Stage::Adam, 1);
        laps.end(Stage::March, 6);
        let all = begun.elapsed().as_secs_f64();
        assert_eq!((stopwatch.units(Stage::March), stopwatch.units(Stage::Adam)), (11, 1));
        assert!(stopwatch.seconds(Stage::March) >= 2e-3);
        assert!(stopwatch.seconds(Stage::March) + stopwatch.seconds(Stage::Adam) <= all);
        assert_eq!(stopwatch.units(Stage::Encode), 0);
        // Without a stopwatch nothing happens.
        Laps::begin(None).end(Stage::March, 1);
        assert_eq!(stopwatch.units(Stage::March), 11);
    }
}
