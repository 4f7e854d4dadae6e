//! How fast the machine is right now, for whoever times something else.

use std::time::Instant;

use fearless_simd::{Level, dispatch};
use pocketnerf_core::{Error, SimdLevel};

use super::{fma, gather};

/// What is read at random places, bytes: as large as a model's tables.
const TABLE: usize = 1 << 20;
/// Calls of a look, each thread.
const CALLS: usize = 60;

/// A piece of work that is always the same: multiply-adds and reads at random places, on
/// all threads at once, as pictures are.
#[derive(Debug)]
pub struct Pace {
    level: Level,
    table: Vec<u64>,
}

impl Pace {
    /// For these vector instructions.
    ///
    /// # Errors
    /// When the SIMD level is not there.
    pub fn new(simd: SimdLevel) -> Result<Self, Error> {
        Ok(Self { level: simd.token()?, table: vec![1; TABLE / 8] })
    }

    /// Seconds that the work takes now, some twenty milliseconds: until the last thread has
    /// finished.
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
