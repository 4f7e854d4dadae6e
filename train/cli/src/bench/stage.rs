//! A stage's time beside what bounds it.

use serde::Serialize;

use super::work::LevelReads;
use crate::machine::{Machine, Rate};

/// The least that a unit of a stage's work takes.
#[derive(Clone, Debug, Default)]
pub(super) struct Demand {
    /// Floating-point operations.
    pub(super) flops: Option<f64>,
    /// Bytes read and written.
    pub(super) bytes: Option<f64>,
    /// Table entries read at random.
    pub(super) reads: Vec<LevelReads>,
    pub(super) bound: Bound,
}

/// Which of the machine's limits applies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Bound {
    /// None of those measured.
    #[default]
    None,
    /// Multiplications and additions.
    Fma,
    /// Random reads.
    Gather,
    /// Sequential reading from so many bytes of memory.
    Bandwidth(f64),
}

impl Bound {
    const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Fma => "fma",
            Self::Gather => "gather",
            Self::Bandwidth(_) => "bandwidth",
        }
    }
}

impl Demand {
    /// Computing in registers.
    pub(super) fn fma(flops: f64) -> Self {
        Self { flops: Some(flops), bound: Bound::Fma, ..Self::default() }
    }

    /// Random reads of tables, and computing with what is read. Unknown if there are no
    /// tables.
    pub(super) fn gather(reads: Vec<LevelReads>, flops: Option<f64>) -> Self {
        if reads.is_empty() {
            return Self::default();
        }
        let bytes = reads.iter().map(|level| level.entries * level.entry_bytes).sum();
        Self { flops, bytes: Some(bytes), reads, bound: Bound::Gather }
    }

    /// Going through `bytes` for every unit, out of `memory` bytes.
    pub(super) fn bandwidth(bytes: f64, memory: f64) -> Self {
        Self { bytes: Some(bytes), bound: Bound::Bandwidth(memory), ..Self::default() }
    }

    /// Thread seconds that a unit takes at the limit.
    fn seconds(&self, machine: &Machine, crowd: Crowd) -> Option<f64> {
        let per_thread = |rate: Rate| match crowd {
            Crowd::OneThread => rate.one_thread,
            Crowd::All => rate.all / machine.threads as f64,
        };
        match self.bound {
            Bound::None => None,
            Bound::Fma => Some(self.flops? / per_thread(machine.flops)),
            Bound::Gather => {
                let level =
                    |l: &LevelReads| l.entries / per_thread(machine.gathers.at(l.table_bytes));
                Some(self.reads.iter().map(level).sum())
            }
            Bound::Bandwidth(memory) => Some(self.bytes? / per_thread(machine.streams.at(memory))),
        }
    }
}

/// How many threads share the machine.
#[derive(Clone, Copy, Debug)]
pub(super) enum Crowd {
    /// One thread alone.
    OneThread,
    /// All threads are at work.
    All,
}

/// Time of one stage, and how close it comes to what bounds it.
#[derive(Clone, Debug, Serialize)]
pub struct StageCost {
    /// Its name.
    pub name: &'static str,
    /// What is counted: ray, sample, ...
    pub unit: &'static str,
    /// How many.
    pub units: u64,
    /// Thread time by samples of the field, nanoseconds.
    pub ns_per_sample: f64,
    /// Thread time by units, nanoseconds.
    pub ns_per_unit: Option<f64>,
    /// Floating-point operations, 10^9 per second of thread time.
    pub gflops: Option<f64>,
    /// Bytes, 10^9 per second of thread time.
    pub gb_per_s: Option<f64>,
    /// Table entries read at random, per second of thread time.
    pub gathers_per_second: Option<f64>,
    /// What bounds it: `fma`, `gather`, `bandwidth` or `none`.
    pub bound: &'static str,
    /// The time at that bound, divided by the measured time.
    pub fraction_of_peak: Option<f64>,
    /// Its share of all thread time.
    pub share: f64,
}

/// Time and work of a stage, as measured.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) units: u64,
    /// Thread time.
    pub(super) seconds: f64,
    pub(super) demand: Demand,
}

/// The stages, and the rest of `seconds` of thread time as the last of them.
pub(super) fn stages(
    measured: &[Measured],
    seconds: f64,
    samples: u64,
    machine: &Machine,
    crowd: Crowd,
) -> Vec<StageCost> {
    let known: f64 = measured.iter().map(|m| m.seconds).sum();
    let rest = Measured {
        name: "rest",
        unit: "sample",
        units: samples,
        seconds: seconds - known,
        demand: Demand::default(),
    };
    let stage = |m: &Measured| {
        let rate = |work: f64| (m.seconds > 0.0).then(|| work * m.units as f64 / m.seconds);
        let entries: f64 = m.demand.reads.iter().map(|level| level.entries).sum();
        StageCost {
            name: m.name,
            unit: m.unit,
            units: m.units,
            ns_per_sample: m.seconds * 1e9 / samples.max(1) as f64,
            ns_per_unit: (m.units > 0).then(|| m.seconds * 1e9 / m.units as f64),
            gflops: m.demand.flops.and_then(rate).map(|r| r * 1e-9),
            gb_per_s: m.demand.bytes.and_then(rate).map(|r| r * 1e-9),
            gathers_per_second: rate(entries).filter(|r| *r > 0.0),
            bound: m.demand.bound.name(),
            fraction_of_peak: m.demand.seconds(machine, crowd).and_then(rate),
            share: m.seconds / seconds,
        }
    };
    measured.iter().chain([&rest]).map(stage).collect()
}

/// The share of all thread time that would remain if every stage with a bound reached it
/// and the others took no time.
pub(super) fn fraction_of_bounds(stages: &[StageCost]) -> f64 {
    stages.iter().filter_map(|stage| Some(stage.share * stage.fraction_of_peak?)).sum()
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::SimdLevel;

    use super::*;
    use crate::machine::{Curve, Point};

    /// 100 GFLOP/s, 2e9 gathers a second and 10 GB/s a thread; three threads are
    /// twice as fast as one.
    fn machine() -> Machine {
        let rate = |one_thread: f64| Rate { one_thread, all: 2.0 * one_thread };
        let curve = |one_thread| Curve(vec![Point { bytes: 1, rate: rate(one_thread) }]);
        Machine {
            simd: SimdLevel::Portable,
            threads: 3,
            lanes: 4,
            clock: 1e9,
            flops: rate(100e9),
            fma_fraction: 1.0,
            streams: curve(10e9),
            gathers: curve(2e9),
        }
    }

    #[test]
    fn fractions_by_hand() {
        let reads = LevelReads { entries: 8.0, entry_bytes: 4.0, table_bytes: 1e6 };
        let measured = |name, demand| Measured {
            name,
            unit: "sample",
            units: 1_000_000,
            seconds: 0.02,
            demand,
        };
        let all = [
            measured("a", Demand::fma(1000.0)),
            measured("b", Demand::gather(vec![reads; 2], Some(40.0))),
            measured("c", Demand::bandwidth(100.0, 1e6)),
            measured("d", Demand::default()),
        ];
        let found = stages(&all, 0.1, 2_000_000, &machine(), Crowd::OneThread);
        let near = |a: Option<f64>, b: f64| assert!((a.unwrap() - b).abs() < 1e-9, "{a:?} {b}");
        // 1e9 FLOP take 10 ms of 20; 16e6 reads take 8 ms; 1e8 bytes 10 ms.
        near(found[0].fraction_of_peak, 0.5);
        near(found[0].gflops, 50.0);
        near(found[1].fraction_of_peak, 0.4);
        near(found[1].gathers_per_second, 8e8);
        near(found[1].gb_per_s, 3.2);
        near(found[2].fraction_of_peak, 0.5);
        near(Some(found[2].ns_per_sample), 10.0);
        near(found[2].ns_per_unit, 20.0);
        assert_eq!((found[3].bound, found[3].fraction_of_peak), ("none", None));
        assert_eq!((found[4].name, found.len()), ("rest", 5));
        near(Some(found.iter().map(|stage| stage.share).sum()), 1.0);
        near(Some(fraction_of_bounds(&found)), 0.2 * (0.5 + 0.4 + 0.5));
        // Of three threads, each has two thirds of what one has alone.
        let found = stages(&all, 0.1, 2_000_000, &machine(), Crowd::All);
        near(found[0].fraction_of_peak, 0.75);
    }
}
