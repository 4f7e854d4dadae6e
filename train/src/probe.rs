//! Densities of a field, a batch of points at a time.

use fearless_simd::Level;
use pocketnerf_core::AnyField;
use pocketnerf_core::lanes::LANES;
use pocketnerf_core::march::{Output, SampleBatch, evaluate};
use pocketnerf_core::network::panel_len;
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
}

impl Probe {
    /// For fields within these limits.
    pub(crate) fn new(limits: Limits) -> Self {
        let rows = |n: usize| Aligned::new(n * STRIDE);
        Self {
            a: rows(limits.width.max(limits.rows[0])),
            b: rows(limits.width.max(limits.rows[1])),
            output: rows((1 + limits.channels).next_multiple_of(LANES)),
            panel: Aligned::new(panel_len(limits.width)),
            points: [rows(1), rows(1), rows(1)],
        }
    }

    /// Unit coordinates of a batch.
    pub(crate) fn points(&mut self) -> &mut [Aligned<f32>; 3] {
        &mut self.points
    }

    /// Sigma at the first `count` points.
    pub(crate) fn densities(&mut self, level: Level, field: &AnyField<'_>, count: usize) -> &[f32] {
        let Self { a, b, output, panel, points } = self;
        let mut samples = SampleBatch {
            points: points.each_mut().map(|row| &mut row[..]),
            directions: [&mut [], &mut [], &mut []],
            t: &mut [],
            capacity: BATCH,
            len: count,
            directed: false,
        };
        let mut work = Workspace { a, b, output, panel, stride: STRIDE, rounded: false };
        evaluate(level, field, Output::Density, &mut samples, &mut work, |_, _| ());
        &self.output[..count]
    }
}
