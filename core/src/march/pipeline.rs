//! The one loop over samples: gather, evaluate, accumulate.

use fearless_simd::Simd;

use crate::AnyField;
use crate::march::{Marcher, Output, RayQueue, SampleBatch, evaluate};
use crate::scratch::Workspace;

/// The stages of rendering and of training's forward pass, to measure them.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Pixels that are the mean of their neighbours or known to be empty, or are found
    /// not to be.
    Interpolate,
    /// Cells cast onto the tile, rays, and their way to the first occupied cell.
    Camera,
    /// The next samples of the rays.
    March,
    /// Positions to numbers.
    Encode,
    /// The density network; with per-sample shading the colour network too.
    Density,
    /// Densities to opacities, and the rays' sums.
    Composite,
    /// What rays have accumulated to pixels; the colour network of deferred shading.
    Shade,
}

/// What samples are for: a picture, the answer to a question, or gradients.
pub trait SampleSink {
    /// The rays.
    type Queue: RayQueue;

    /// The rays whose samples these are.
    fn queue(&mut self) -> &mut Self::Queue;

    /// Adds an evaluated batch to its rays: sigma of its samples is in row 0 of
    /// `work.output`, what rays accumulate in the rows after it.
    fn accumulate<S: Simd>(&mut self, simd: S, samples: &SampleBatch<'_>, work: &mut Workspace<'_>);

    /// Whether there have been more samples than are allowed: rays then stop where they are.
    fn is_spent(&self) -> bool {
        false
    }

    /// Is called when a part of a stage has ended, with the number of samples.
    fn ended(&mut self, stage: Stage, n: usize) {
        let _ = (stage, n);
    }
}

/// Takes the `active` rays, by their numbers in the sink's queue, to their ends: batch
/// after batch, each with the next samples of all rays that are still active.
#[inline(always)]
pub fn march<S: Simd>(
    simd: S,
    field: &AnyField<'_>,
    output: Output,
    marcher: &Marcher<'_>,
    (samples, work): (&mut SampleBatch<'_>, &mut Workspace<'_>),
    mut active: &mut [u32],
    sink: &mut impl SampleSink,
) {
    samples.directed = output == Output::Channels && field.deferred().is_none();
    loop {
        samples.len = 0;
        let n_active = gather(simd, marcher, sink.queue(), active, samples);
        active = &mut active[..n_active];
        sink.ended(Stage::March, samples.len);
        if active.is_empty() {
            return;
        }
        if samples.len == 0 {
            // Rays have been seeking.
            continue;
        }
        evaluate(simd.level(), field, output, samples, work, |stage, n| sink.ended(stage, n));
        sink.accumulate(simd, samples, work);
        sink.ended(Stage::Composite, samples.len);
        if sink.is_spent() {
            return;
        }
    }
}

/// [`Marcher::gather`], compiled for the register width.
fn gather<S: Simd>(
    simd: S,
    marcher: &Marcher<'_>,
    queue: &mut impl RayQueue,
    active: &mut [u32],
    samples: &mut SampleBatch<'_>,
) -> usize {
    simd.vectorize(
        #[inline(always)]
        || marcher.gather(simd, queue, active, samples),
    )
}
