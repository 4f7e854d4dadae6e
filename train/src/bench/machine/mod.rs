//! What the machine can do at best, at one SIMD level.

mod clock;
mod curve;
mod fma;
mod gather;
mod rate;
mod stream;

use fearless_simd::{Level, Simd, SimdBase, dispatch};
use pocketnerf_core::{Error, SimdLevel};
use rayon::prelude::*;

pub use curve::{Curve, Point};
pub use rate::Rate;

use crate::aligned::Aligned;
use rate::Effort;

/// Buffers that are streamed: one that stays in a second-level cache, one that
/// stays in a third-level cache, one that no cache holds.
const STREAMS: [usize; 3] = [1 << 20, 16 << 20, 256 << 20];
/// What a thread streams at least.
const LEAST_PART: usize = 1 << 20;
/// Tables that are read at random places.
const TABLES: [usize; 5] = [256 << 10, 1 << 20, 4 << 20, 16 << 20, 64 << 20];

/// What the machine can do at best.
#[derive(Clone, Debug)]
pub struct Machine {
    /// Vector instructions that were measured with.
    pub simd: SimdLevel,
    /// Threads of the rates of all.
    pub threads: usize,
    /// `f32` values of a register.
    pub lanes: usize,
    /// Cycles a second of one core.
    pub clock: f64,
    /// Floating-point operations a second, `f32`, in registers.
    pub flops: Rate,
    /// What one core reaches of two fused multiply-adds a cycle.
    pub fma_fraction: f64,
    /// Bytes a second, read one after the other. A thread has its own part of the
    /// buffer, but at least a megabyte.
    pub streams: Curve,
    /// Reads of eight bytes a second, at random places of one table.
    pub gathers: Curve,
}

impl Machine {
    /// Measures on all threads of the current pool: two to three seconds, or less
    /// and rougher if `quick`.
    ///
    /// # Errors
    /// When the SIMD level is not there.
    pub fn measure(simd: SimdLevel, quick: bool) -> Result<Self, Error> {
        let level = simd.token()?;
        let effort = Effort::of(quick);
        let clock = clock(&effort);
        let flops = dispatch!(level, simd => registers(&effort, simd));
        let lanes = dispatch!(level, simd => lanes(simd));
        Ok(Self {
            simd,
            threads: rayon::current_num_threads(),
            lanes,
            clock,
            flops,
            fma_fraction: flops.one_thread / (clock * lanes as f64 * 4.0),
            streams: streams(&effort, level),
            gathers: gathers(&effort, level),
        })
    }
}

/// Cycles a second of one core, now: neighbours and heat slow it down.
#[must_use]
pub fn clock_now(quick: bool) -> f64 {
    clock(&Effort::of(quick))
}

fn clock(effort: &Effort) -> f64 {
    effort.one_thread(clock::CYCLES, clock::chain)
}

#[inline(always)]
fn lanes<S: Simd>(_: S) -> usize {
    S::f32s::LEN
}

#[inline(always)]
fn registers<S: Simd>(effort: &Effort, simd: S) -> Rate {
    effort.rate(fma::flops::<S>(), |_| fma::multiply_add(simd))
}

fn streams(effort: &Effort, level: Level) -> Curve {
    let threads = rayon::current_num_threads();
    let part = |bytes: usize| (bytes / threads).max(LEAST_PART) / 1024 * 1024;
    let largest = STREAMS[STREAMS.len() - 1].max(threads * LEAST_PART);
    // Not zeros: the system would give the same page again and again.
    let mut memory = Aligned::<f32>::new(largest / 4);
    memory.par_chunks_mut(1 << 16).for_each(|values| values.fill(1.0));
    let points = STREAMS.map(|bytes| {
        // The lone thread reads all of it, each of many its part.
        let sum = |thread: usize, len: usize| {
            let values = &memory[thread * len / 4..][..len / 4];
            dispatch!(level, simd => stream::sum(simd, values));
        };
        let one_thread = effort.one_thread(bytes as f64, || sum(0, bytes));
        let part = part(bytes);
        let all = effort.all(part as f64, |thread| sum(thread, part));
        Point { bytes, rate: Rate { one_thread, all } }
    });
    Curve(points.to_vec())
}

fn gathers(effort: &Effort, level: Level) -> Curve {
    let mut memory = Aligned::<u64>::new(TABLES[TABLES.len() - 1] / 8);
    memory.par_chunks_mut(1 << 16).for_each(|values| values.fill(1));
    let points = TABLES.map(|bytes| {
        let table = &memory[..bytes / 8];
        let rate = effort.rate(gather::READS, |thread| {
            dispatch!(level, simd => gather::read(simd, table, thread as u32));
        });
        Point { bytes, rate }
    });
    Curve(points.to_vec())
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
