//! All ways to round a model.

use pocketnerf_core::{Camera, Model};
use pocketnerf_formats::{ModelFile, Precision, open, pack, unpacked, write};

use super::candidates::{Candidate, candidates};
use super::parts::Parts;
use super::pictures::Pictures;
use super::tables;
use super::{CompactError, Compacted};
use crate::picture::Settings;

/// A model as it is.
pub(super) struct Whole<'c> {
    /// Its file, entries that nothing reads cleared.
    ordinary: Vec<u8>,
    pub(super) pictures: Pictures<'c>,
}

impl<'c> Whole<'c> {
    pub(super) fn read(
        packed: &[u8],
        cameras: &'c [Camera],
        settings: &Settings,
    ) -> Result<Self, CompactError> {
        let ordinary = unpacked(packed)?.into_owned();
        let model = open(&ordinary)?.model;
        if tables::all(&model).is_empty() {
            return Err(CompactError::NoTables);
        }
        let pictures = Pictures::of(&model, cameras, settings)?;
        Ok(Self { ordinary, pictures })
    }

    /// The file with tables of eight bits.
    pub(super) fn in_eight_bits(&self) -> Result<Vec<u8>, CompactError> {
        let file = open(&self.ordinary)?;
        let are_bytes = |model| {
            let tables = tables::all(model);
            tables.iter().all(|table| table.dtype() == pocketnerf_core::DType::I8)
        };
        match are_bytes(&file.model) {
            true => Ok(self.ordinary.clone()),
            false => Ok(write(&file.model, &file.about, Precision::I8)?),
        }
    }
}

/// The steps that can be chosen, and what they give.
pub(super) struct Search<'w> {
    whole: &'w Whole<'w>,
    parts: Parts<'w>,
    /// Of each part.
    pub(super) candidates: Vec<Vec<Candidate>>,
    /// Steps that training has got used to, of the tables.
    known: Vec<u16>,
}

impl<'w> Search<'w> {
    /// Tries the steps of each part of `file`, which has tables of eight bits.
    pub(super) fn begin(
        whole: &'w Whole<'w>,
        file: &'w [u8],
        lengths: Option<&[f32]>,
    ) -> Result<Self, CompactError> {
        let file: ModelFile<'w> = open(file)?;
        let tables = tables::all(&file.model);
        let units = tables.iter().map(|table| f32::from(table.scale_log2()).exp2());
        let steps = units.zip(lengths.unwrap_or_default()).map(|(unit, length)| length / unit);
        let known: Vec<u16> = steps.map(|step| step.round().clamp(1.0, 127.0) as u16).collect();
        let parts = Parts::of(file);
        let candidates = candidates(&parts, &known, &whole.pictures)?;
        Ok(Self { whole, parts, candidates, known })
    }

    /// The numbers of the steps that training has got used to.
    pub(super) fn known(&self) -> Vec<Option<usize>> {
        let number = |(i, part): (usize, &Vec<Candidate>)| {
            let step = self.known.get(i)?;
            part.iter().position(|candidate| candidate.step == *step)
        };
        self.candidates.iter().enumerate().map(number).collect()
    }

    fn steps(&self, chosen: &[usize]) -> Vec<u16> {
        self.candidates.iter().zip(chosen).map(|(part, i)| part[*i].step).collect()
    }

    /// The ordinary file with parts of these steps.
    pub(super) fn rounded(&self, chosen: &[usize]) -> Result<Vec<u8>, CompactError> {
        let steps = self.steps(chosen);
        Ok(self.parts.file(|part| self.parts.rounded(part, steps[part]))?)
    }

    /// The same, packed.
    pub(super) fn packed(&self, chosen: &[usize]) -> Result<Vec<u8>, CompactError> {
        Ok(pack(&self.rounded(chosen)?)?)
    }

    pub(super) fn compacted(&self, chosen: &[usize]) -> Result<Compacted, CompactError> {
        let (bytes, mut steps) = (self.packed(chosen)?, self.steps(chosen));
        let smaller = unpacked(&bytes)?;
        let model = open(&smaller)?.model;
        let psnr = -10.0 * self.whole.pictures.difference(&model)?.error.log10();
        let network_steps = steps.split_off(tables::all(&model).len());
        let lengths = lengths_of(&model, &steps);
        Ok(Compacted { bytes, steps, network_steps, lengths, psnr })
    }
}

/// How long steps are.
pub(super) fn lengths_of(model: &Model<'_>, steps: &[u16]) -> Vec<f32> {
    let tables = tables::all(model);
    let tables = tables.iter().zip(steps);
    tables.map(|(table, step)| f32::from(*step) * f32::from(table.scale_log2()).exp2()).collect()
}
