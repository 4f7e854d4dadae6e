//! The parts of a model file that can be rounded: tables and large matrices.

use pocketnerf_core::{AnyField, DType};
use pocketnerf_formats::{ContainerWriter, ModelFile, Section, WriteError, kind, packed_plane_len};

use super::{networks, tables};

/// Smaller matrices take too few bytes.
const LEAST_MATRIX: usize = 1024;

/// Parts of a model whose tables have eight bits: tables first, in their order.
pub(super) struct Parts<'f> {
    pub(super) file: ModelFile<'f>,
    parts: Vec<Section<'f>>,
    n_tables: usize,
    /// Values of an entry.
    features: usize,
    /// Entries in a row, where tables are planes, each before its line.
    row: Option<u16>,
}

impl<'f> Parts<'f> {
    pub(super) fn of(file: ModelFile<'f>) -> Self {
        let all = tables::all(&file.model);
        let features = all.first().map_or(1, |table| table.cols());
        let n_tables = all.len();
        let is_half = file.tensors().all(|(_, tensor)| tensor.dtype() != DType::F32);
        let of = |kind| file.sections().filter(move |section| section.id.kind == kind);
        let matrices = of(kind::NETWORK).filter(|matrix| matrix.bytes.len() >= LEAST_MATRIX);
        let parts = of(kind::GRID).chain(matrices.filter(|_| is_half)).collect();
        let row = match &file.model.field {
            AnyField::Planes(field) => u16::try_from(field.planes.resolution).ok(),
            _ => None,
        };
        Self { file, parts, n_tables, features, row }
    }

    pub(super) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Whether a part is a table.
    pub(super) fn is_table(&self, part: usize) -> bool {
        part < self.n_tables
    }

    /// A part's values, multiples of `step`; as they are where that is 1.
    pub(super) fn rounded(&self, part: usize, step: u16) -> Vec<u8> {
        let bytes = self.parts[part].bytes;
        match self.is_table(part) {
            true => tables::rounded(bytes, step as u8),
            false => networks::rounded(bytes, step),
        }
    }

    /// Bytes that these take, packed, about.
    pub(super) fn rate(&self, part: usize, step: u16) -> f64 {
        let values = self.rounded(part, step);
        match self.is_table(part) {
            true => match self.row.filter(|_| part.is_multiple_of(2)) {
                Some(row) => packed_plane_len(&values, row) as f64,
                None => tables::rate(&values, self.features),
            },
            false => networks::rate(&values, step),
        }
    }

    /// The file with other `values` of its parts.
    pub(super) fn file(&self, values: impl Fn(usize) -> Vec<u8>) -> Result<Vec<u8>, WriteError> {
        let mut writer = ContainerWriter::new();
        for section in self.file.sections() {
            let (id, version, critical) = (section.id, section.version, section.is_critical());
            match self.parts.iter().position(|part| part.id == id) {
                Some(part) => writer.add(id, version, critical, values(part)),
                None => writer.add(id, version, critical, section.bytes),
            }
        }
        writer.finish()
    }

    /// The file with another step of one part.
    pub(super) fn with(&self, part: usize, step: u16) -> Result<Vec<u8>, WriteError> {
        self.file(|i| match i == part {
            true => self.rounded(i, step),
            false => self.parts[i].bytes.to_vec(),
        })
    }
}
