//! A model in fewer bytes than packing alone gives, without photographs: values of its tables are
//! rounded to multiples of coarser steps, a step a level, chosen so that pictures change least
//! for the bytes that are saved.
//!
//! Fine levels bear coarse steps: their part of a picture is small. What each step of each level
//! does to pictures and to bytes is measured, one level at a time; the errors of levels add up.

mod choice;
mod error;
mod tables;

use pocketnerf_core::{Camera, Error, Model};
use pocketnerf_formats::{
    ContainerWriter, ModelFile, Precision, SectionId, kind, open, pack, unpacked, write,
};

pub use error::CompactError;

use crate::picture::{Renderer, Settings};
use choice::{Candidate, choose};
use tables::{levels, rate, rounded, with_table};

/// Steps to choose from, in units of the stored values.
const STEPS: [u8; 15] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64];
/// A level is tried no further once pictures differ by more than this mean squared error, 20 dB.
const WORST: f64 = 1e-2;
/// How often the choice is corrected by what packing really gives.
const CORRECTIONS: usize = 8;

/// A model that was made smaller.
#[derive(Clone, Debug, PartialEq)]
pub struct Compacted {
    /// The packed file.
    pub bytes: Vec<u8>,
    /// The step of each level, in units of the stored values; 1: as it was.
    pub steps: Vec<u8>,
    /// Its pictures against the model's own, over the model's background, all pixels together,
    /// dB; infinite where nothing changed.
    pub psnr: f64,
}

/// Packs the ordinary `file` into at most `most` bytes. Pictures are compared from `cameras`, of
/// which a dozen small ones suffice.
///
/// # Errors
/// [`CompactError::TooSmall`] if no choice of steps is that small; what opening, rendering or
/// writing reports.
pub fn to_bytes(
    file: &[u8],
    most: usize,
    cameras: &[Camera],
    settings: &Settings,
) -> Result<Compacted, CompactError> {
    let packed = pack(file)?;
    let file = unpacked(&packed)?;
    let opened = open(&file)?;
    let n_levels = levels(&opened.model).len();
    if packed.len() <= most {
        return Ok(Compacted { bytes: packed, steps: vec![1; n_levels], psnr: f64::INFINITY });
    }
    let settings = Settings { quality: 1.0, depth: false, ..*settings };
    let own = pictures(&opened.model, cameras, &settings)?;
    let in_bytes = in_eight_bits(&opened)?;
    let file = in_bytes.as_deref().unwrap_or(&file);
    let opened = open(file)?;
    // Eight bits instead of sixteen change pictures too.
    let base = difference(&opened.model, (cameras, &own), &settings)?;
    let mut candidates = Vec::with_capacity(n_levels);
    for level in 0..n_levels {
        candidates.push(measure((&opened.model, base), level, (cameras, &own), &settings)?);
    }
    let rest = rest(file, &opened)?;
    let mut budget = most as f64 - rest;
    let mut best: Option<(Vec<u8>, Vec<u8>)> = None;
    for _ in 0..CORRECTIONS {
        let Some(chosen) = choose(&candidates, budget) else { break };
        let steps: Vec<u8> = chosen.iter().map(|i| STEPS[*i]).collect();
        let bytes = assembled(&opened, &steps)?;
        let over = bytes.len() as f64 - most as f64;
        if over <= 0.0 && best.as_ref().is_none_or(|(best, _)| bytes.len() > best.len()) {
            best = Some((bytes, steps));
        }
        // Rates are estimates; a little less than what is left, so that it ends below.
        budget -= if over > 0.0 { over } else { 0.9 * over };
    }
    let Some((bytes, steps)) = best else {
        let least: f64 = candidates.iter().filter_map(|c| c.last()).map(|c| c.rate).sum();
        let least = (least + rest).ceil() as usize;
        return Err(CompactError::TooSmall { most, least });
    };
    let smaller = unpacked(&bytes)?;
    let error = difference(&open(&smaller)?.model, (cameras, &own), &settings)?;
    Ok(Compacted { psnr: -10.0 * error.log10(), bytes, steps })
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

/// What each step of a level does, beside the `base` that pictures differ by anyway.
fn measure(
    (model, base): (&Model<'_>, f64),
    level: usize,
    pictures: (&[Camera], &[Vec<f32>]),
    settings: &Settings,
) -> Result<Vec<Candidate>, Error> {
    let mut candidates = Vec::new();
    for step in STEPS {
        let table = rounded(levels(model)[level].bytes(), step);
        let error = match step {
            1 => 0.0,
            _ => difference(&with_table(model, level, &table)?, pictures, settings)? - base,
        };
        let rate = rate(&table, levels(model)[level].cols());
        candidates.push(Candidate { error, rate });
        if error > WORST {
            break;
        }
    }
    Ok(candidates)
}

/// Bytes of a packed file beside its tables.
fn rest(bytes: &[u8], file: &ModelFile<'_>) -> Result<f64, CompactError> {
    let tables = levels(&file.model).iter();
    let all: f64 = tables.map(|table| rate(table.bytes(), table.cols())).sum();
    Ok(pack(bytes)?.len() as f64 - all)
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
