//! What the machine can do at best, at one SIMD level.

mod clock;
mod curve;
mod fma;
mod gather;
mod pace;
mod rate;
mod stream;

use std::time::Duration;

use fearless_simd::{Level, Simd, SimdBase, dispatch};
use pocketnerf_core::{Error, SimdLevel};
use pocketnerf_train::aligned::Aligned;
use rayon::prelude::*;

pub use curve::{Curve, Point};
pub use pace::Pace;
pub use rate::Rate;

use rate::Span;

/// Buffers that are streamed: within the second-level cache, within the third-level cache,
/// and beyond all caches.
const STREAMS: [usize; 3] = [1 << 20, 16 << 20, LARGEST_STREAM];
const LARGEST_STREAM: usize = 256 << 20;
/// The least that a thread streams.
const LEAST_PART: usize = 1 << 20;
/// Tables that are read at random places.
const TABLES: [usize; 5] = [256 << 10, 1 << 20, 4 << 20, 16 << 20, 64 << 20];

/// What the machine can do at best.
#[derive(Clone, Debug)]
pub struct Machine {
    /// Vector instructions that were measured with.
    pub simd: SimdLevel,
    /// Number of threads.
    pub threads: usize,
    /// `f32` values of a register.
    pub lanes: usize,
    /// Cycles per second of one core.
    pub clock: f64,
    /// Floating-point operations per second, `f32`, in registers.
    pub flops: Rate,
    /// The share of two fused multiply-adds per cycle that one core reaches.
    pub fma_fraction: f64,
    /// Bytes per second of sequential reading. A thread has its own part of the
    /// buffer, but at least a megabyte.
    pub streams: Curve,
    /// Random reads of eight bytes per second, from one table.
    pub gathers: Curve,
}

impl Machine {
    /// Measures on all threads of the current pool: two to three seconds, or less
    /// and rougher if `quick`.
    ///
    /// # Errors
    /// If the machine lacks the SIMD level.
    pub fn measure(simd: SimdLevel, quick: bool) -> Result<Self, Error> {
        let level = simd.token()?;
        let (span, rounds) = span_and_rounds(quick);
        let (values, entries) = (values(), filled(TABLES[TABLES.len() - 1] / 8, 1));
        // In rounds, so that a disturbance does not hit all measurements of one rate.
        let look = || Look::take(level, span, &values, &entries);
        let mut best = look();
        for _ in 1..rounds {
            best = best.best(&look());
        }
        let Look { mut clock, flops, streams, gathers } = best;
        let lanes = dispatch!(level, simd => lanes(simd));
        let threads = rayon::current_num_threads();
        let fraction = |clock| flops.one_thread / (clock * lanes as f64 * 4.0);
        for _ in 0..MORE_LOOKS {
            if fraction(clock) <= 1.0 {
                break;
            }
            // No core multiplies that fast: something disturbed the clock's measurement.
            clock = clock.max(clock_now(quick));
        }
        let fma_fraction = fraction(clock);
        Ok(Self { simd, threads, lanes, clock, flops, fma_fraction, streams, gathers })
    }
}

/// Further looks at a clock at most.
const MORE_LOOKS: usize = 32;

/// How long one measurement takes, and how many there are.
const fn span_and_rounds(quick: bool) -> (Span, usize) {
    let (span, rounds) = if quick { (2, 2) } else { (15, 7) };
    (Span(Duration::from_millis(span)), rounds)
}

/// Current cycles per second of one core: other load and heat slow it down.
#[must_use]
pub fn clock_now(quick: bool) -> f64 {
    let (span, rounds) = span_and_rounds(quick);
    (0..rounds).map(|_| span.one_thread(clock::CYCLES, clock::chain)).fold(0.0, f64::max)
}

#[inline(always)]
fn lanes<S: Simd>(_: S) -> usize {
    S::f32s::LEN
}

/// The buffer that is streamed.
fn values() -> Aligned<f32> {
    filled(LARGEST_STREAM.max(rayon::current_num_threads() * LEAST_PART) / 4, 1.0)
}

/// Not zeros: the system would map one page again and again.
fn filled<T: Copy + Default + Send + Sync>(len: usize, value: T) -> Aligned<T> {
    let mut memory = Aligned::new(len);
    memory.par_chunks_mut(1 << 16).for_each(|part| part.fill(value));
    memory
}

/// One measurement of everything.
struct Look {
    clock: f64,
    flops: Rate,
    streams: Curve,
    gathers: Curve,
}

impl Look {
    fn take(level: Level, span: Span, values: &[f32], entries: &[u64]) -> Self {
        Self {
            clock: span.one_thread(clock::CYCLES, clock::chain),
            flops: dispatch!(level, simd => registers(span, simd)),
            streams: streams(level, span, values),
            gathers: gathers(level, span, entries),
        }
    }

    fn best(self, other: &Self) -> Self {
        Self {
            clock: self.clock.max(other.clock),
            flops: self.flops.best(other.flops),
            streams: self.streams.best(&other.streams),
            gathers: self.gathers.best(&other.gathers),
        }
    }
}

#[inline(always)]
fn registers<S: Simd>(span: Span, simd: S) -> Rate {
    span.rate(fma::flops::<S>(), |_| fma::multiply_add(simd))
}

fn streams(level: Level, span: Span, values: &[f32]) -> Curve {
    let point = |bytes| Point { bytes, rate: stream(level, span, values, bytes) };
    Curve(STREAMS.map(point).to_vec())
}

/// One thread reads all of it; each of many reads its part.
fn stream(level: Level, span: Span, values: &[f32], bytes: usize) -> Rate {
    let part = (bytes / rayon::current_num_threads()).max(LEAST_PART) / 1024 * 1024;
    let sum = |thread: usize, bytes: usize| {
        let values = &values[thread * bytes / 4..][..bytes / 4];
        dispatch!(level, simd => stream::sum(simd, values));
    };
    let one_thread = span.one_thread(bytes as f64, || sum(0, bytes));
    Rate { one_thread, all: span.all(part as f64, |thread| sum(thread, part)) }
}

fn gathers(level: Level, span: Span, entries: &[u64]) -> Curve {
    let points = TABLES.map(|bytes| {
        let table = &entries[..bytes / 8];
        let rate = span.rate(gather::READS, |thread| {
            dispatch!(level, simd => gather::read(simd, table, thread as u32));
        });
        Point { bytes, rate }
    });
    Curve(points.to_vec())
}

/// Measures the machine again while something else is measured.
pub(crate) struct Probe {
    level: Level,
    span: Span,
    values: Aligned<f32>,
}

impl Probe {
    pub(crate) fn new(simd: SimdLevel, quick: bool) -> Result<Self, Error> {
        Ok(Self { level: simd.token()?, span: span_and_rounds(quick).0, values: values() })
    }

    /// Floating-point operations per second in registers, and bytes per second of memory
    /// beyond all caches.
    pub(crate) fn look(&self) -> [Rate; 2] {
        let flops = dispatch!(self.level, simd => registers(self.span, simd));
        [flops, stream(self.level, self.span, &self.values, LARGEST_STREAM)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_can_be_measured() {
        for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
            let machine = Machine::measure(simd, true).unwrap();
            let points = machine.streams.0.iter().chain(&machine.gathers.0).map(|p| p.rate);
            for rate in points.chain([machine.flops]) {
                assert!(rate.one_thread > 0.0 && rate.one_thread.is_finite(), "{machine:?}");
                assert!(rate.all > 0.0 && rate.all.is_finite(), "{machine:?}");
            }
            // An unoptimised build is slow, but nothing is folded away.
            assert!(machine.clock > 1e7 && machine.clock < 2e10, "{machine:?}");
            assert!(machine.fma_fraction > 1e-3 && machine.fma_fraction < 3.0, "{machine:?}");
        }
    }
}
