//! From evaluated samples to what their rays accumulate.

use core::ops::Range;

use fearless_simd::Simd;

use crate::lanes::{self, LANES};
use crate::march::composite::{Lengths, opacities};
use crate::march::{RaySlot, RaySlots, SampleBatch, SampleRun, SampleSink, Stage};
use crate::render::RenderStats;
use crate::render::observe::Observer;
use crate::scratch::{Workspace, sums_len};

/// Where the samples of a picture go.
pub(super) struct Compositor<'c, 's, 'o, 'f> {
    pub(super) slots: &'c mut RaySlots<'s>,
    /// [`sums_len`] sums a ray.
    pub(super) sums: &'c mut [f32],
    pub(super) channels: usize,
    /// Distance between samples.
    pub(super) step: f32,
    pub(super) stats: &'c mut RenderStats,
    /// Samples that are allowed, all pixels together.
    pub(super) max_samples: u64,
    pub(super) observer: &'c mut Option<&'o mut Observer<'f>>,
}

impl<'s> SampleSink for Compositor<'_, 's, '_, '_> {
    type Queue = RaySlots<'s>;

    #[inline(always)]
    fn queue(&mut self) -> &mut RaySlots<'s> {
        self.slots
    }

    /// Opaque rays end.
    fn accumulate<S: Simd>(
        &mut self,
        simd: S,
        samples: &SampleBatch<'_>,
        work: &mut Workspace<'_>,
    ) {
        let n = samples.len;
        self.stats.samples += n as u64;
        let sigma = &mut work.output[..n.next_multiple_of(LANES)];
        opacities(simd, sigma, Lengths::Equal(self.step));
        simd.vectorize(
            #[inline(always)]
            || {
                let mut run = SampleRun::NONE;
                for first in (0..n).step_by(LANES) {
                    run = self.add(simd, samples, work, first..n.min(first + LANES), run);
                }
            },
        );
    }

    #[inline(always)]
    fn is_spent(&self) -> bool {
        self.stats.samples > self.max_samples
    }

    #[inline(always)]
    fn ended(&mut self, stage: Stage, n: usize) {
        if let Some(observer) = self.observer {
            observer(stage, n);
        }
    }
}

impl Compositor<'_, '_, '_, '_> {
    /// Adds up to sixteen samples, the first of which are what is left of a run; returns
    /// what is left of the last.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        batch: &SampleBatch<'_>,
        work: &Workspace<'_>,
        samples: Range<usize>,
        run: SampleRun,
    ) -> SampleRun {
        let RaySlots { rays, runs, limits, .. } = &mut *self.slots;
        let min_transmittance = limits.min_transmittance;
        let mut weights = [0.0; LANES];
        let mut rest = run;
        let mut at = samples.start;
        while let Some((ray, piece)) = rest.next(runs, at..samples.end) {
            at = piece.end;
            let row = &mut rays[ray];
            let mut slot = RaySlot::load(row);
            for s in piece {
                if slot.accumulated.transmittance < min_transmittance {
                    // It has become opaque within this batch.
                    break;
                }
                let mut alpha = work.output[s];
                let mut steps = slot.state.steps;
                while steps > 1.0 {
                    alpha *= 2.0 - alpha;
                    steps *= 0.5;
                }
                weights[s - samples.start] = slot.accumulated.add(alpha, batch.t[s]);
                slot.last_transmittance = 1.0 - alpha;
            }
            if slot.accumulated.transmittance < min_transmittance {
                slot.state.stop();
            }
            slot.store(row);
        }
        let row_len = sums_len(self.channels);
        let mut values = [0.0; LANES * LANES];
        for part in (0..row_len).step_by(LANES) {
            let from = &work.output[part * work.stride + samples.start..];
            let from = (from, work.stride, 1 + self.channels - part);
            lanes::transpose(simd, from, (&mut values, LANES), LANES);
            let values = values.as_chunks::<LANES>().0;
            let (mut rest, mut at) = (run, samples.start);
            while let Some((ray, piece)) = rest.next(runs, at..samples.end) {
                at = piece.end;
                let sums = &mut self.sums[ray * row_len + part..][..LANES];
                for s in piece {
                    let (weight, values) = (weights[s - samples.start], &values[s - samples.start]);
                    // What has no weight may be no number.
                    if weight > 0.0 {
                        for (sum, value) in sums.iter_mut().zip(values) {
                            *sum += weight * value;
                        }
                    }
                }
            }
        }
        rest
    }
}
