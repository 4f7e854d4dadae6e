//! Samples of many rays, those of a ray one after another.

use fearless_simd::{Simd, SimdBase};

use crate::march::ray_packet::LANES;
use crate::march::ray_state::RUN;

/// Where samples are put, until it is full.
#[derive(Debug)]
pub struct SampleBatch<'b> {
    /// Unit coordinates x, y, z; distances along the rays. All of one length, at
    /// least 16.
    pub rows: [&'b mut [f32]; 4],
    /// Samples so far.
    pub len: usize,
}

/// A register's samples.
pub(super) type Offer = [[f32; LANES]; 4];

impl SampleBatch<'_> {
    /// Samples that it has room for in all.
    #[inline(always)]
    pub(super) fn capacity(&self) -> usize {
        self.rows[0].len()
    }

    /// Adds `count` samples, at most [`RUN`], from `first` on.
    #[inline(always)]
    pub(super) fn accept(&mut self, offer: &Offer, first: usize, count: usize) {
        for (to, from) in self.rows.iter_mut().zip(offer) {
            let from = &from[first..];
            match (to[self.len..].first_chunk_mut::<RUN>(), from.first_chunk::<RUN>()) {
                // What lies beyond is overwritten by who comes next.
                (Some(to), Some(from)) => *to = *from,
                _ => to[self.len..][..count].copy_from_slice(&from[..count]),
            }
        }
        self.len += count;
    }
}

/// Writes down what a register holds.
#[inline(always)]
pub(super) fn offer<S: Simd>(u: [S::f32s; 3], t: S::f32s) -> Offer {
    let mut rows = [[0.0; LANES]; 4];
    for (row, value) in rows.iter_mut().zip([u[0], u[1], u[2], t]) {
        value.store_slice(&mut row[..S::f32s::LEN]);
    }
    rows
}
