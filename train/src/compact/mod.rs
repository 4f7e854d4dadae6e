//! A model in fewer bytes than packing alone gives, without photographs: values of its tables are
//! rounded to multiples of coarser steps, a step a level, chosen so that pictures change least
//! for the bytes that are saved.
//!
//! Fine levels bear coarse steps: their part of a picture is small. What each step of each level
//! does to pictures and to bytes is measured, one level at a time; the errors of levels add up.

mod choice;
mod error;
mod tables;

use pocketnerf_core::{Camera, Error, Model, TensorView};
use pocketnerf_formats::{
    ContainerWriter, ModelFile, Precision, SectionId, kind, open, pack, unpacked, write,
};

pub use error::CompactError;

use crate::dataset::thin;
use crate::picture::{Renderer, Settings};
use choice::{Candidate, choose};
use tables::{levels, rate, rounded, with_table};

/// Views from which pictures are compared.
pub const VIEWS: usize = 12;
/// Their longer sides at most, pixels.
const SIDE: u32 = 128;
/// Steps to choose from, in units of the stored values.
const STEPS: [u8; 16] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 127];
/// Steps of which pictures are rendered. Errors of the other steps are interpolated.
const LOOKED_AT: [u8; 5] = [4, 12, 32, 64, 127];
/// A level is tried no further once pictures differ by more than this mean squared error, 20 dB.
const WORST: f64 = 1e-2;
/// Smaller differences are noise.
const LEAST: f64 = 1e-12;

/// A model that was made smaller.
#[derive(Clone, Debug, PartialEq)]
pub struct Compacted {
    /// The packed file.
    pub bytes: Vec<u8>,
    /// The step of each level, in units of the stored values; 1: as it was.
    pub steps: Vec<u8>,
    /// The lengths of these steps.
    pub lengths: Vec<f32>,
    /// Its pictures against the model's own, over the model's background, all pixels together,
    /// dB; infinite where nothing changed.
    pub psnr: f64,
}

/// Packs the ordinary `file` into at most `most` bytes. Pictures are compared from `cameras`, of
/// which a dozen small ones suffice. Where training has got used to steps of some `lengths`, a
/// level each, these are only refined, if they fit.
///
/// # Errors
/// [`CompactError::TooSmall`] if no choice of steps is that small; what opening, rendering or
/// writing reports.
pub fn to_bytes(
    file: &[u8],
    most: usize,
    lengths: Option<&[f32]>,
    cameras: &[Camera],
    settings: &Settings,
) -> Result<Compacted, CompactError> {
    let packed = pack(file)?;
    let file = unpacked(&packed)?;
    let opened = open(&file)?;
    let n_levels = levels(&opened.model).len();
    if packed.len() <= most {
        let steps = vec![1; n_levels];
        let lengths = lengths_of(&opened.model, &steps);
        return Ok(Compacted { bytes: packed, steps, lengths, psnr: f64::INFINITY });
    }
    let settings = Settings { quality: 1.0, depth: false, ..*settings };
    let own = pictures(&opened.model, cameras, &settings)?;
    let in_bytes = in_eight_bits(&opened)?;
    let file = in_bytes.as_deref().unwrap_or(&file);
    let opened = open(file)?;
    // Eight bits instead of sixteen change pictures too.
    let base = difference(&opened.model, (cameras, &own), &settings)?;
    let known = |(table, length): (&TensorView<'_>, &f32)| {
        let unit = f32::from(table.scale_log2()).exp2();
        (length / unit).round().clamp(1.0, 127.0) as u8
    };
    let tables = levels(&opened.model).iter();
    let known: Option<Vec<u8>> = lengths.map(|lengths| tables.zip(lengths).map(known).collect());
    let mut candidates = Vec::with_capacity(n_levels);
    for level in 0..n_levels {
        let level = (level, known.as_ref().map(|known| known[level]));
        candidates.push(measure((&opened.model, base), level, (cameras, &own), &settings)?);
    }
    // The numbers of those that training has got used to, if all are there.
    let begins = known.and_then(|known| {
        let numbers = candidates.iter().zip(known);
        let number =
            |(level, step): (&Vec<Candidate>, u8)| level.iter().position(|c| c.step == step);
        numbers.map(number).collect::<Option<Vec<usize>>>()
    });
    let steps = |chosen: &[usize]| {
        candidates.iter().zip(chosen).map(|(level, i)| level[*i].step).collect::<Vec<u8>>()
    };
    let mut least = usize::MAX;
    let chosen = choose(&candidates, begins, |chosen| {
        let bytes = assembled(&opened, &steps(chosen))?.len();
        least = least.min(bytes);
        Ok::<_, CompactError>(bytes <= most)
    })?;
    let Some(chosen) = chosen else { return Err(CompactError::TooSmall { most, least }) };
    let steps = steps(&chosen);
    let bytes = assembled(&opened, &steps)?;
    let smaller = unpacked(&bytes)?;
    let error = difference(&open(&smaller)?.model, (cameras, &own), &settings)?;
    let lengths = lengths_of(&opened.model, &steps);
    Ok(Compacted { psnr: -10.0 * error.log10(), bytes, steps, lengths })
}

/// How long steps are.
fn lengths_of(model: &Model<'_>, steps: &[u8]) -> Vec<f32> {
    let tables = levels(model).iter().zip(steps);
    tables.map(|(table, step)| f32::from(*step) * f32::from(table.scale_log2()).exp2()).collect()
}

/// Cameras from which pictures of such models are compared: a dozen small ones of these, evenly
/// spread.
#[must_use]
pub fn small(mut cameras: Vec<Camera>) -> Vec<Camera> {
    thin(&mut cameras, VIEWS);
    let side = |camera: &Camera| camera.width.max(camera.height);
    cameras.iter().map(|camera| camera.downscaled(side(camera).div_ceil(SIDE))).collect()
}

/// The file with tables of eight bits, where it has others.
fn in_eight_bits(file: &ModelFile<'_>) -> Result<Option<Vec<u8>>, CompactError> {
    let tables = levels(&file.model);
    if tables.is_empty() {
        return Err(CompactError::NoTables);
    }
    if tables.iter().all(|table| table.dtype() == pocketnerf_core::DType::I8) {
        return Ok(None);
    }
    Ok(Some(write(&file.model, &file.about, Precision::I8)?))
}

/// What each step of a level does, beside the `base` that pictures differ by anyway; the one that
/// training knows among them.
fn measure(
    (model, base): (&Model<'_>, f64),
    (level, known): (usize, Option<u8>),
    pictures: (&[Camera], &[Vec<f32>]),
    settings: &Settings,
) -> Result<Vec<Candidate>, Error> {
    let table = levels(model)[level];
    let mut looks = Vec::with_capacity(LOOKED_AT.len());
    for step in LOOKED_AT {
        let coarse = rounded(table.bytes(), step);
        let error = difference(&with_table(model, level, &coarse)?, pictures, settings)? - base;
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

/// The packed file with tables of these steps.
fn assembled(file: &ModelFile<'_>, steps: &[u8]) -> Result<Vec<u8>, CompactError> {
    let mut writer = ContainerWriter::new();
    for section in file.sections() {
        let step = match section.id {
            SectionId { kind: kind::GRID, index } => steps.get(index as usize).copied(),
            _ => None,
        };
        let (id, version, critical) = (section.id, section.version, section.is_critical());
        match step {
            Some(step) => writer.add(id, version, critical, rounded(section.bytes, step)),
            None => writer.add(id, version, critical, section.bytes),
        }
    }
    Ok(pack(&writer.finish()?)?)
}

/// Colours over the model's background, picture after picture.
fn pictures(
    model: &Model<'_>,
    cameras: &[Camera],
    settings: &Settings,
) -> Result<Vec<Vec<f32>>, Error> {
    let mut renderer = Renderer::new(model, settings);
    let over = |camera| Ok(renderer.render(camera)?.over(model.display.background));
    cameras.iter().map(over).collect()
}

/// Mean squared difference from these pictures.
fn difference(
    model: &Model<'_>,
    (cameras, own): (&[Camera], &[Vec<f32>]),
    settings: &Settings,
) -> Result<f64, Error> {
    let (mut sum, mut n) = (0.0, 0);
    for (picture, own) in pictures(model, cameras, settings)?.iter().zip(own) {
        n += own.len();
        sum += picture.iter().zip(own).map(|(a, b)| f64::from((a - b).powi(2))).sum::<f64>();
    }
    Ok(sum / n.max(1) as f64)
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
