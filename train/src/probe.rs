//! Asks a field for densities, a batch of points at a time.

use fearless_simd::{Level, dispatch};
use pocketnerf_core::field::{Field, Samples};
use pocketnerf_core::scratch::{Limits, Tuning, Workspace};

use crate::aligned::Aligned;

/// Points a batch.
pub(crate) const BATCH: usize = 512;
/// Values between rows.
const STRIDE: usize = Tuning { samples: BATCH, rays: 1 }.stride();

/// One thread's memory.
#[derive(Debug)]
pub(crate) struct Probe {
    a: Aligned<f32>,
    b: Aligned<f32>,
    output: Aligned<f32>,
    panel: Aligned<f32>,
    points: [Aligned<f32>; 3],
    /// Zeros: no density depends on it.
    direction: Aligned<f32>,
}

impl Probe {
    /// For fields within these limits.
    pub(crate) fn new(limits: Limits) -> Self {
        let rows = |n: usize| Aligned::new(n * STRIDE);
        Self {
            a: rows(limits.width.max(limits.rows[0])),
            b: rows(limits.width.max(limits.rows[1])),
            output: rows((1 + limits.channels).next_multiple_of(16)),
            panel: Aligned::new(pocketnerf_core::network::panel_len(limits.width)),
            points: [rows(1), rows(1), rows(1)],
            direction: rows(1),
        }
    }

    /// Unit coordinates of a batch.
    pub(crate) fn points(&mut self) -> &mut [Aligned<f32>; 3] {
        &mut self.points
    }

    /// Sigma at the first `count` points.
    pub(crate) fn densities<F: Field>(&mut self, level: Level, field: &F, count: usize) -> &[f32] {
        let padded = count.next_multiple_of(32);
        let Self { a, b, output, panel, points, direction } = self;
        for row in points.iter_mut() {
            row[count..padded].fill(0.0);
        }
        let mut work = Workspace { a, b, output, panel, stride: STRIDE };
        dispatch!(level, simd => {
            let samples = Samples {
                points: [0, 1, 2].map(|a| &points[a][..padded]),
                directions: [&direction[..padded]; 3],
            };
            field.densities(simd, samples, &mut work);
        });
        &self.output[..count]
    }
}
