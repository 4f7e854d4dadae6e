//! What the steps of each level do to pictures and to bytes.

use pocketnerf_core::{Error, Model};

use super::pictures::Pictures;
use super::tables::{levels, rate, rounded, with_table};

/// Steps to choose from, in units of the stored values.
const STEPS: [u8; 16] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 127];
/// Steps of which pictures are rendered. Errors of the other steps are interpolated.
pub(super) const LOOKED_AT: [u8; 5] = [4, 12, 32, 64, 127];
/// A level is tried no further once pictures differ by more than this mean squared error, 20 dB.
const WORST: f64 = 1e-2;
/// Smaller differences are noise.
const LEAST: f64 = 1e-12;

/// What a step of a level does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// Units of a step.
    pub(super) step: u8,
    /// Mean squared difference of pictures.
    pub(super) error: f64,
    /// Bytes.
    pub(super) rate: f64,
}

/// The candidates of each level of a model with tables of eight bits, finer ones first; the steps
/// that training knows are among them.
pub(super) fn candidates(
    model: &Model<'_>,
    known: Option<&[u8]>,
    pictures: &Pictures<'_>,
) -> Result<Vec<Vec<Candidate>>, Error> {
    // Eight bits instead of sixteen change pictures too.
    let base = pictures.difference(model)?;
    let known = |level| known.and_then(|known| known.get(level).copied());
    let levels = 0..levels(model).len();
    levels.map(|level| measure((model, base), (level, known(level)), pictures)).collect()
}

/// What each step of a level does, beside the `base` that pictures differ by anyway.
fn measure(
    (model, base): (&Model<'_>, f64),
    (level, known): (usize, Option<u8>),
    pictures: &Pictures<'_>,
) -> Result<Vec<Candidate>, Error> {
    let table = levels(model)[level];
    let mut looks = Vec::with_capacity(LOOKED_AT.len());
    for step in LOOKED_AT {
        let coarse = rounded(table.bytes(), step);
        let error = pictures.difference(&with_table(model, level, &coarse)?)? - base;
        looks.push((f64::from(step), error.max(LEAST)));
        if error > WORST {
            break;
        }
    }
    let last = looks.last().map_or(1.0, |(step, _)| *step);
    let mut steps: Vec<u8> = STEPS.into_iter().chain(known).collect();
    steps.sort_unstable();
    steps.dedup();
    let candidate = |step: u8| Candidate {
        step,
        error: if step == 1 { 0.0 } else { between(&looks, f64::from(step)) },
        rate: rate(&rounded(table.bytes(), step), table.cols()),
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
