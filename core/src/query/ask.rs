//! A batch of points to the field: the one place where questions open its kind.

use fearless_simd::{Simd, dispatch};

use crate::field::{AnyField, Field, Samples, Shading};
use crate::march::LANES;
use crate::query::Probe;
use crate::scratch::Scratch;

/// What is asked of a batch.
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

    /// Asks about the first `n` points and directions of the scratch. Row 0 of its output
    /// then holds sigma, per unit of the model; rows 1 to 3 the colours, where they are
    /// wanted. Gives the distance between these rows.
    pub(super) fn ask(&self, wanted: Wanted, n: usize, scratch: &mut Scratch<'_>) -> usize {
        dispatch!(self.level, simd => match &self.model.field {
            #[cfg(feature = "hash-grid")]
            AnyField::HashGrid(field) => evaluate(simd, field, wanted, n, scratch),
            #[cfg(feature = "nerf")]
            AnyField::Nerf(field) => evaluate(simd, field, wanted, n, scratch),
        })
    }
}

#[inline(always)]
fn evaluate<S: Simd, F: Field>(
    simd: S,
    field: &F,
    wanted: Wanted,
    n: usize,
    scratch: &mut Scratch<'_>,
) -> usize {
    let padded = n.next_multiple_of(LANES);
    let Scratch { work, points, directions, .. } = scratch;
    for row in points.iter_mut().chain(directions.iter_mut()) {
        row[n..padded].fill(0.0);
    }
    let samples = Samples {
        points: [0, 1, 2].map(|axis| &points[axis][..padded]),
        directions: [0, 1, 2].map(|axis| &directions[axis][..padded]),
    };
    let stride = work.stride;
    if wanted == Wanted::Density {
        field.densities(simd, samples, work);
        return stride;
    }
    field.density_features(simd, samples, work);
    let Some(decoder) = field.deferred() else { return stride };
    // As if each point were all that a ray meets.
    let mut work = work.for_width(decoder.color.max_width());
    let features = work.output[stride..].chunks(stride);
    for (to, from) in work.a.chunks_mut(work.stride).zip(features).take(decoder.channels()) {
        to[..padded].copy_from_slice(&from[..padded]);
    }
    decoder.colors(simd, samples.directions, padded, &mut work);
    work.stride
}
