//! The one place that evaluates a field: encode, pad, decode.

use fearless_simd::Level;

use crate::AnyField;
use crate::field::Samples;
use crate::lanes::LANES;
use crate::march::{SampleBatch, Stage};
use crate::scratch::Workspace;

/// What of a field is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Sigma, in row 0 of the workspace's output.
    Density,
    /// Sigma, and in the rows after it what a ray accumulates.
    Channels,
}

/// Evaluates the field at all samples of a batch, whose rows are padded with zeros to a
/// multiple of 16. `ended` is called after each half with the number of samples.
pub fn evaluate(
    level: Level,
    field: &AnyField<'_>,
    output: Output,
    samples: &mut SampleBatch<'_>,
    work: &mut Workspace<'_>,
    mut ended: impl FnMut(Stage, usize),
) {
    let (n, padded) = (samples.len, samples.len.next_multiple_of(LANES));
    let SampleBatch { points, directions, .. } = samples;
    let pad = |rows: &mut [&mut [f32]; 3]| {
        rows.iter_mut().for_each(|row| row[n..padded].fill(0.0));
    };
    pad(points);
    let points = [0, 1, 2].map(|axis| &points[axis][..padded]);
    field.encode(level, points, work);
    ended(Stage::Encode, n);
    match output {
        Output::Density => field.decode_density(level, padded, work),
        Output::Channels => {
            pad(directions);
            let directions = [0, 1, 2].map(|axis| &directions[axis][..padded]);
            field.decode(level, Samples { points, directions }, work);
        }
    }
    ended(Stage::Density, n);
}
