//! Batches of points through the field.

use fearless_simd::dispatch;

use crate::field::Shading;
use crate::lanes::LANES;
use crate::march::{Output, evaluate};
use crate::query::Probe;
use crate::scratch::Scratch;

/// What is computed for a batch.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    Density,
    Radiance,
}

impl Probe<'_> {
    /// Most points of a batch.
    pub(super) fn room(&self, wanted: Wanted, scratch: &mut Scratch<'_>) -> usize {
        let most = self.tuning.samples;
        match (wanted, self.model.field.decoder()) {
            (Wanted::Radiance, Some(decoder)) if decoder.shading == Shading::PerRay => {
                most.min(scratch.work.for_width(decoder.color.max_width()).stride)
            }
            _ => most,
        }
    }

    /// Evaluates the first `n` points and directions of the scratch. Row 0 of its output
    /// then holds sigma, per unit of the model; rows 1 to 3 the colours, where they are
    /// wanted. Returns the distance between these rows.
    pub(super) fn evaluate(&self, wanted: Wanted, n: usize, scratch: &mut Scratch<'_>) -> usize {
        let Scratch { work, samples, .. } = scratch;
        samples.len = n;
        let stride = work.stride;
        let (field, output) = match wanted {
            Wanted::Density => (&self.model.field, Output::Density),
            Wanted::Radiance => (&self.model.field, Output::Channels),
        };
        evaluate(self.level, field, output, samples, work, |_, _| ());
        let deferred = field.deferred().filter(|_| wanted == Wanted::Radiance);
        let Some(decoder) = deferred else { return stride };
        // As if each point were all that a ray meets.
        let padded = n.next_multiple_of(LANES);
        let mut work = work.for_width(decoder.color.max_width());
        let features = work.output[stride..].chunks(stride);
        let rows = work.a.chunks_mut(work.stride).zip(features);
        for (to, from) in rows.take(decoder.channels()) {
            to[..padded].copy_from_slice(&from[..padded]);
        }
        let directions = [0, 1, 2].map(|axis| &samples.directions[axis][..padded]);
        dispatch!(self.level, simd => decoder.colors(simd, directions, padded, &mut work));
        work.stride
    }
}
