//! Samples of many rays, those of a ray one after another.

use fearless_simd::{Simd, SimdBase};

use crate::lanes::LANES;
use crate::march::take::RUN;

/// A batch of samples, in the caller's memory. All rows have the same length: `capacity`
/// rounded up to a multiple of 16.
#[derive(Debug)]
pub struct SampleBatch<'b> {
    /// Unit coordinates x, y, z.
    pub points: [&'b mut [f32]; 3],
    /// Unit directions of the samples' rays; only filled in where `directed`.
    pub directions: [&'b mut [f32]; 3],
    /// Distances along the rays.
    pub t: &'b mut [f32],
    /// Most samples, at least 16.
    pub capacity: usize,
    /// Samples so far.
    pub len: usize,
    /// Whether samples need directions: where each has a colour of its own.
    pub directed: bool,
}

/// What a register holds of samples: x, y, z and t.
pub(super) type Candidates = [[f32; LANES]; 4];

impl SampleBatch<'_> {
    /// Samples that still find room.
    #[inline(always)]
    pub(super) const fn room(&self) -> usize {
        self.capacity - self.len
    }

    /// Adds `count` candidates, at most [`RUN`], from `first` on.
    #[inline(always)]
    pub(super) fn accept(&mut self, candidates: &Candidates, first: usize, count: usize) {
        let Self { points: [x, y, z], t, len, .. } = self;
        for (to, from) in [x, y, z, t].into_iter().zip(candidates) {
            let from = &from[first..];
            match (to[*len..].first_chunk_mut::<RUN>(), from.first_chunk::<RUN>()) {
                // What lies beyond is overwritten by the next samples.
                (Some(to), Some(from)) => *to = *from,
                _ => to[*len..][..count].copy_from_slice(&from[..count]),
            }
        }
        self.len += count;
    }

    /// Fills in the direction of the ray of the `count` samples from `first` on.
    #[inline(always)]
    pub(super) fn direct(&mut self, direction: [f32; 3], first: usize, count: usize) {
        for (row, d) in self.directions.iter_mut().zip(direction) {
            row[first..first + count].fill(d);
        }
    }
}

/// Stores what a register holds.
#[inline(always)]
pub(super) fn candidates<S: Simd>(u: [S::f32s; 3], t: S::f32s) -> Candidates {
    let mut rows = [[0.0; LANES]; 4];
    for (row, value) in rows.iter_mut().zip([u[0], u[1], u[2], t]) {
        value.store_slice(&mut row[..S::f32s::LEN]);
    }
    rows
}
