//! What the steps of each part do to pictures and to bytes.

use pocketnerf_formats::open;

use super::parts::Parts;
use super::pictures::Pictures;
use super::{CompactError, MOST_WORK};

/// Steps of a table to choose from, in units of the stored values; the last leaves nothing but 0.
const OF_TABLES: [u16; 17] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 127, 255];
/// Steps of a matrix, of which the largest value is stored as 2^14 to 2^15.
const OF_MATRICES: [u16; 10] = [1, 8, 16, 32, 64, 128, 256, 512, 1024, 2048];
/// Steps of which pictures are rendered. Errors of the other steps are interpolated.
const LOOKED_AT: [&[u16]; 2] = [&[4, 12, 40, 127, 255], &[32, 128, 512]];
/// How often a table is looked at, and a matrix.
pub(super) const LOOKS: [usize; 2] = [LOOKED_AT[0].len(), LOOKED_AT[1].len()];
/// How often the bytes of a table are found: for planes it is packed, which is counted.
pub(super) const RATES: usize = OF_TABLES.len();
/// A part is tried no further once pictures differ by more than this mean squared error, 20 dB.
const WORST: f64 = 1e-2;
/// Smaller differences are noise.
const LEAST: f64 = 1e-12;

/// What a step of a part does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// Units of a step.
    pub(super) step: u16,
    /// Mean squared difference of pictures.
    pub(super) error: f64,
    /// Bytes.
    pub(super) rate: f64,
}

/// The candidates of each part, finer ones first; the steps of levels that training knows are
/// among them.
pub(super) fn candidates(
    parts: &Parts<'_>,
    known: &[u16],
    pictures: &Pictures<'_>,
) -> Result<Vec<Vec<Candidate>>, CompactError> {
    // Eight bits instead of sixteen change pictures too.
    let base = pictures.difference(&parts.file.model)?.error;
    let measured = |part| measure((parts, base), (part, known.get(part).copied()), pictures);
    (0..parts.len()).map(measured).collect()
}

/// What each step of a part does, beside the `base` that pictures differ by anyway.
fn measure(
    (parts, base): (&Parts<'_>, f64),
    (part, known): (usize, Option<u16>),
    pictures: &Pictures<'_>,
) -> Result<Vec<Candidate>, CompactError> {
    let (steps, looked_at) = match parts.is_table(part) {
        true => (&OF_TABLES[..], LOOKED_AT[0]),
        false => (&OF_MATRICES[..], LOOKED_AT[1]),
    };
    let mut looks = Vec::with_capacity(looked_at.len());
    for step in looked_at {
        let file = parts.with(part, *step)?;
        let found = pictures.difference(&open(&file)?.model)?;
        // What renders more slowly is as bad as what looks worst.
        let error = if found.work > MOST_WORK { WORST } else { found.error - base };
        looks.push((f64::from(*step), error.max(LEAST)));
        if error >= WORST {
            break;
        }
    }
    let tried_to_the_end = looks.len() == looked_at.len();
    let last = looks.last().filter(|_| !tried_to_the_end).map_or(f64::INFINITY, |look| look.0);
    let mut steps: Vec<u16> = steps.iter().copied().chain(known).collect();
    steps.sort_unstable();
    steps.dedup();
    // No byte is spent on a difference that is noise.
    let error = |step| Some(between(&looks, step)).filter(|error| *error > LEAST).unwrap_or(0.0);
    let candidate = |step: u16| Candidate {
        step,
        error: if step == 1 { 0.0 } else { error(f64::from(step)) },
        rate: parts.rate(part, step),
    };
    Ok(steps.into_iter().filter(|step| f64::from(*step) <= last).map(candidate).collect())
}

/// The error of a step between two whose errors are known, as a power of the step; below the
/// first it is as the square of the step, as that of noise.
fn between(looks: &[(f64, f64)], step: f64) -> f64 {
    let after = looks.partition_point(|(looked_at, _)| *looked_at < step).min(looks.len() - 1);
    let (far, error) = looks[after];
    let power = match after.checked_sub(1).map(|before| looks[before]) {
        Some((near, before)) => (error / before).ln() / (far / near).ln(),
        None => 2.0,
    };
    error * (step / far).powf(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_between_looks_by_hand() {
        // The square below the first, the cube between both.
        let looks = [(4.0, 1e-4), (8.0, 8e-4)];
        for (step, expected) in [(2.0, 2.5e-5), (4.0, 1e-4), (6.0, 3.375e-4), (8.0, 8e-4)] {
            let found = between(&looks, step);
            assert!((found / expected - 1.0).abs() < 1e-9, "{step}: {found}");
        }
    }
}
