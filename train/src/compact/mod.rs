//! A model in fewer bytes than packing alone gives, without photographs: values of its tables are
//! rounded to multiples of coarser steps, a step a level, chosen so that pictures change least
//! for the bytes that are saved.
//!
//! Fine levels bear coarse steps: their part of a picture is small. What each step of each level
//! does to pictures and to bytes is measured, one level at a time; the errors of levels add up.

mod candidates;
mod choice;
mod error;
mod pictures;
mod tables;

use pocketnerf_core::{Camera, Error, Model};
use pocketnerf_formats::{
    ContainerWriter, ModelFile, Precision, SectionId, kind, open, pack, unpacked, write,
};

pub use error::CompactError;
pub use pictures::{Pictures, VIEWS, small};

use crate::picture::Settings;
use candidates::{Candidate, candidates};
use choice::{choose, coarsest};
use tables::{levels, rounded, with_table};

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
    if packed.len() <= most {
        return unchanged(packed);
    }
    let whole = Whole::read(&packed, cameras, settings)?;
    let file = whole.in_eight_bits()?;
    let search = Search::begin(&whole, &file, lengths)?;
    let mut least = usize::MAX;
    let chosen = choose(&search.candidates, search.begins(), |chosen| {
        let bytes = search.assembled(chosen)?.len();
        least = least.min(bytes);
        Ok::<_, CompactError>(bytes <= most)
    })?;
    let Some(chosen) = chosen else { return Err(CompactError::TooSmall { most, least }) };
    search.compacted(&chosen)
}

/// Packs the ordinary `file` into as few bytes as possible while the model is good, which
/// `is_good` is asked, given the file's own pictures from `cameras`. Where none is good, nothing is
/// rounded.
///
/// # Errors
/// What opening, rendering or writing reports.
pub fn smallest(
    file: &[u8],
    cameras: &[Camera],
    settings: &Settings,
    mut is_good: impl FnMut(&Model<'_>, &Pictures<'_>) -> Result<bool, Error>,
) -> Result<Compacted, CompactError> {
    let packed = pack(file)?;
    let whole = Whole::read(&packed, cameras, settings)?;
    let file = whole.in_eight_bits()?;
    let search = Search::begin(&whole, &file, None)?;
    let chosen = coarsest(&search.candidates, |chosen| {
        let tables = search.tables(chosen);
        let mut model = search.file.model;
        for (level, table) in tables.iter().enumerate() {
            model = with_table(&model, level, table)?;
        }
        is_good(&model, &whole.pictures)
    })?;
    match chosen {
        Some(chosen) => search.compacted(&chosen),
        None => unchanged(packed),
    }
}

/// How often pictures of all views are rendered and a file is packed to find a size, at most,
/// about, where a model has so many levels.
pub(crate) const fn work(levels: usize) -> [usize; 2] {
    let tried = choice::HALVINGS + 2 * levels;
    [candidates::LOOKED_AT.len() * levels + tried, tried]
}

/// With no step longer than a unit.
fn unchanged(packed: Vec<u8>) -> Result<Compacted, CompactError> {
    let file = unpacked(&packed)?;
    let model = open(&file)?.model;
    let steps = vec![1; levels(&model).len()];
    let lengths = lengths_of(&model, &steps);
    Ok(Compacted { bytes: packed, steps, lengths, psnr: f64::INFINITY })
}

/// A model as it is.
struct Whole<'c> {
    /// Its file, entries that nothing reads cleared.
    ordinary: Vec<u8>,
    pictures: Pictures<'c>,
}

impl<'c> Whole<'c> {
    fn read(
        packed: &[u8],
        cameras: &'c [Camera],
        settings: &Settings,
    ) -> Result<Self, CompactError> {
        let ordinary = unpacked(packed)?.into_owned();
        let model = open(&ordinary)?.model;
        if levels(&model).is_empty() {
            return Err(CompactError::NoTables);
        }
        let pictures = Pictures::of(&model, cameras, settings)?;
        Ok(Self { ordinary, pictures })
    }

    /// The file with tables of eight bits.
    fn in_eight_bits(&self) -> Result<Vec<u8>, CompactError> {
        let file = open(&self.ordinary)?;
        let are_bytes = |model| {
            let mut tables = levels(model).iter();
            tables.all(|table| table.dtype() == pocketnerf_core::DType::I8)
        };
        match are_bytes(&file.model) {
            true => Ok(self.ordinary.clone()),
            false => Ok(write(&file.model, &file.about, Precision::I8)?),
        }
    }
}

/// The steps that can be chosen, and what they give.
struct Search<'w> {
    whole: &'w Whole<'w>,
    file: ModelFile<'w>,
    /// Of each level.
    candidates: Vec<Vec<Candidate>>,
    /// Steps that training has got used to.
    known: Option<Vec<u8>>,
}

impl<'w> Search<'w> {
    /// Tries the steps of each level of `file`, which has tables of eight bits.
    fn begin(
        whole: &'w Whole<'w>,
        file: &'w [u8],
        lengths: Option<&[f32]>,
    ) -> Result<Self, CompactError> {
        let file = open(file)?;
        let tables = levels(&file.model).iter();
        let known: Option<Vec<u8>> = lengths.map(|lengths| {
            let units = tables.map(|table| f32::from(table.scale_log2()).exp2());
            let steps = units.zip(lengths).map(|(unit, length)| length / unit);
            steps.map(|step| step.round().clamp(1.0, 127.0) as u8).collect()
        });
        let candidates = candidates(&file.model, known.as_deref(), &whole.pictures)?;
        Ok(Self { whole, file, candidates, known })
    }

    /// The numbers of the steps that training has got used to, if all are there.
    fn begins(&self) -> Option<Vec<usize>> {
        let numbers = self.candidates.iter().zip(self.known.as_ref()?);
        numbers.map(|(level, step)| level.iter().position(|c| c.step == *step)).collect()
    }

    fn steps(&self, chosen: &[usize]) -> Vec<u8> {
        self.candidates.iter().zip(chosen).map(|(level, i)| level[*i].step).collect()
    }

    /// Tables of these steps.
    fn tables(&self, chosen: &[usize]) -> Vec<Vec<u8>> {
        let tables = levels(&self.file.model).iter().zip(self.steps(chosen));
        tables.map(|(table, step)| rounded(table.bytes(), step)).collect()
    }

    /// The packed file with tables of these steps.
    fn assembled(&self, chosen: &[usize]) -> Result<Vec<u8>, CompactError> {
        let tables = self.tables(chosen);
        let mut writer = ContainerWriter::new();
        for section in self.file.sections() {
            let table = match section.id {
                SectionId { kind: kind::GRID, index } => tables.get(index as usize),
                _ => None,
            };
            let bytes = table.map_or(section.bytes, |table| table);
            writer.add(section.id, section.version, section.is_critical(), bytes);
        }
        Ok(pack(&writer.finish()?)?)
    }

    fn compacted(&self, chosen: &[usize]) -> Result<Compacted, CompactError> {
        let (bytes, steps) = (self.assembled(chosen)?, self.steps(chosen));
        let smaller = unpacked(&bytes)?;
        let error = self.whole.pictures.difference(&open(&smaller)?.model)?;
        let lengths = lengths_of(&self.file.model, &steps);
        Ok(Compacted { psnr: -10.0 * error.log10(), bytes, steps, lengths })
    }
}

/// How long steps are.
fn lengths_of(model: &Model<'_>, steps: &[u8]) -> Vec<f32> {
    let tables = levels(model).iter().zip(steps);
    tables.map(|(table, step)| f32::from(*step) * f32::from(table.scale_log2()).exp2()).collect()
}
