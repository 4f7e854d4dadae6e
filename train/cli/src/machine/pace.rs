//! The current speed of the machine, to correct other timings.

use std::time::Instant;

use fearless_simd::{Level, dispatch};
use pocketnerf_core::{Error, SimdLevel};

use super::{fma, gather};

/// Bytes that are read at random, about a model's tables.
const TABLE: usize = 1 << 20;
/// Calls of one measurement, per thread.
const CALLS: usize = 60;

/// A constant piece of work: multiply-adds and random reads on all threads at once, like
/// rendering.
#[derive(Debug)]
pub struct Pace {
    level: Level,
    table: Vec<u64>,
}

impl Pace {
    /// For these vector instructions.
    ///
    /// # Errors
    /// If the machine lacks the SIMD level.
    pub fn new(simd: SimdLevel) -> Result<Self, Error> {
        Ok(Self { level: simd.token()?, table: vec![1; TABLE / 8] })
    }

    /// Seconds that the work takes now, about 0.02, until the last thread has finished.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let begun = Instant::now();
        rayon::broadcast(|thread| {
            for _ in 0..CALLS {
                let (table, seed) = (&self.table[..], thread.index() as u32);
                dispatch!(self.level, simd => {
                    for _ in 0..8 { fma::multiply_add(simd); }
                    gather::read(simd, table, seed);
                });
            }
        });
        begun.elapsed().as_secs_f64()
    }
}
