//! From a model to bytes.

mod container;
mod eight_bits;
mod error;
mod f16;
mod pack;

use alloc::vec::Vec;

use pocketnerf_core::{AnyField, DType, Display, Layout, Model, TensorView};
use serde::Serialize;

pub use container::ContainerWriter;
pub use error::WriteError;
pub use pack::pack;
#[cfg(feature = "planes")]
pub use pack::packed_plane_len;

use crate::about::{About, PixelOrigin, World};
use crate::container::{SectionId, kind};
use crate::directory::write_directory;
use crate::metadata::field::{self, tensors};
use crate::metadata::{V1, about, append, photographs, space, world};
use crate::tensor_name::Role;
use crate::{FormatError, ModelFile, reader};

/// How weights are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Four bytes a weight, unchanged.
    F32,
    /// Two bytes a weight, eleven significant bits, with a scale per tensor.
    #[default]
    F16,
    /// A byte a table entry's value, with a scale per level; networks as in `F16`.
    I8,
}

/// The bytes of a `.pnerf` file. The same model gives the same bytes.
///
/// # Errors
/// [`WriteError`]; a file that [`open`](crate::open) would refuse is never written.
pub fn write(
    model: &Model<'_>,
    about: &About<'_>,
    precision: Precision,
) -> Result<Vec<u8>, WriteError> {
    let mut writer = ContainerWriter::new();
    writer.add_model(model, about, precision)?;
    let bytes = writer.finish()?;
    reader::open(&bytes)?;
    Ok(bytes)
}

/// A copy of the file with this [quality](About::quality). All other sections stay as they
/// are, including those of other programs.
///
/// # Errors
/// [`WriteError::Unsupported`] for a quality outside 0 to 1.
pub fn with_quality(file: &ModelFile<'_>, quality: f32) -> Result<Vec<u8>, WriteError> {
    let mut writer = ContainerWriter::new();
    for section in file.sections().filter(|section| section.id.kind != kind::QUALITY) {
        writer.add_section(&section);
    }
    writer.add_quality(quality)?;
    writer.finish()
}

/// A copy of the file that says this of the dataset's coordinates. All other sections stay as they
/// are.
///
/// # Errors
/// Those of [`ContainerWriter::finish`].
pub fn with_world(file: &ModelFile<'_>, world: &World) -> Result<Vec<u8>, WriteError> {
    let mut writer = ContainerWriter::new();
    for section in file.sections().filter(|section| section.id.kind != kind::WORLD) {
        writer.add_section(&section);
    }
    writer.optional(kind::WORLD, &world::write(world));
    writer.finish()
}

impl<'a> ContainerWriter<'a> {
    /// Adds the sections of a model, so that a program can put its own beside them.
    ///
    /// # Errors
    /// [`WriteError::NotFinite`], [`WriteError::OutOfRange`] and
    /// [`WriteError::Unsupported`]; [`WriteError::Unreadable`] where the model's
    /// parts do not fit together.
    pub fn add_model(
        &mut self,
        model: &Model<'a>,
        about: &About<'_>,
        precision: Precision,
    ) -> Result<(), WriteError> {
        model.validate().map_err(FormatError::Model)?;
        self.required(kind::SCENE, encode(&about::write_scene(&about.scene)));
        let bytes =
            space::write_space(&model.space, Vec::new()).ok_or(WriteError::Unsupported("space"))?;
        self.required(kind::SPACE, bytes);
        self.required(kind::SAMPLING, encode(&space::write_sampling(&model.sampling)));
        let bytes =
            field::write(&model.field, Vec::new()).ok_or(WriteError::Unsupported("field"))?;
        self.required(kind::FIELD, bytes);
        let display = about::write_display(&model.display, about.camera.as_ref())
            .ok_or(WriteError::Unsupported("colour space"))?;
        self.required(kind::DISPLAY, encode(&display));
        // The rest is optional: readers may ignore it.
        if model.display.tolerance != Display::TOLERANCE {
            self.optional(kind::DETAIL, &about::write_detail(model.display.tolerance));
        }
        if about.pixel_origin != PixelOrigin::Center {
            self.optional(kind::PIXELS, &about::write_pixels(about.pixel_origin));
        }
        if let Some(quality) = about.quality {
            self.add_quality(quality)?;
        }
        if let Some(photographs) = &about.photographs {
            self.optional(kind::PHOTOGRAPHS, &photographs::write(photographs));
        }
        if about.world != World::default() {
            self.optional(kind::WORLD, &world::write(&about.world));
        }
        if let Some(hierarchical) = &model.hierarchical {
            self.optional(kind::HIERARCHICAL, &space::write_hierarchical(hierarchical));
        }
        if let Some(provenance) = &about.provenance {
            self.optional(kind::PROVENANCE, &about::write_provenance(provenance));
        }
        if let Some(occupancy) = &model.occupancy {
            let (resolution, n_cascades) = (occupancy.resolution(), occupancy.n_cascades());
            let size = space::OccupancyV1 { resolution, n_cascades };
            self.required(kind::OCCUPANCY, encode(&size));
            self.add(SectionId::first(kind::OCC_COARSE), V1, true, occupancy.coarse_bytes());
            self.add(SectionId::first(kind::OCC_FINE), V1, true, occupancy.fine_bytes());
        }
        self.add_tensors(&model.field, precision)
    }

    fn add_quality(&mut self, quality: f32) -> Result<(), WriteError> {
        if !(0.0..=1.0).contains(&quality) {
            return Err(WriteError::Unsupported("quality"));
        }
        self.optional(kind::QUALITY, &about::write_quality(quality));
        Ok(())
    }

    fn required(&mut self, kind: u32, bytes: Vec<u8>) {
        self.add(SectionId::first(kind), V1, true, bytes);
    }

    fn optional(&mut self, kind: u32, value: &impl Serialize) {
        self.add(SectionId::first(kind), V1, false, encode(value));
    }

    fn add_tensors(
        &mut self,
        field: &AnyField<'_>,
        precision: Precision,
    ) -> Result<(), WriteError> {
        let mut stored = Vec::new();
        for (name, view) in tensors(field) {
            if view.layout() != Layout::RowMajor {
                return Err(WriteError::Unsupported("tensor layout"));
            }
            let (dtype, bytes, scale_log2) = match (precision, name.role()) {
                (_, Role::Index) => (DType::U16, view.bytes().to_vec(), 0),
                (_, Role::Exact) | (Precision::F32, _) => {
                    (DType::F32, f16::to_f32(name, &view)?, 0)
                }
                (Precision::I8, Role::Table) => {
                    let (bytes, scale_log2) = eight_bits::to_i8(name, &view)?;
                    (DType::I8, bytes, scale_log2)
                }
                (Precision::F16 | Precision::I8, _) => {
                    let (bytes, scale_log2) = f16::to_f16(name, &view)?;
                    (DType::F16, bytes, scale_log2)
                }
            };
            stored.push((name, view.shape(), dtype, scale_log2, bytes));
        }
        let mut n_network = 0;
        let mut directory = Vec::with_capacity(stored.len());
        for (name, shape, dtype, scale_log2, bytes) in &stored {
            let section = match name.role() {
                Role::Table => SectionId { kind: kind::GRID, index: name.index },
                // Beside the only table of its kind.
                Role::Index => SectionId { kind: kind::GRID, index: 1 },
                _ => SectionId { kind: kind::NETWORK, index: n_network },
            };
            n_network += u32::from(section.kind == kind::NETWORK);
            let view = TensorView::new(bytes, *dtype, *shape, *scale_log2, Layout::RowMajor)
                .map_err(FormatError::Model)?;
            directory.push((*name, view, section));
        }
        let bytes = write_directory(directory.iter().copied(), Vec::new())
            .ok_or(WriteError::Unsupported("tensor type"))?;
        self.required(kind::TENSORS, bytes);
        let sections: Vec<SectionId> = directory.iter().map(|(_, _, section)| *section).collect();
        for (section, (.., bytes)) in sections.into_iter().zip(stored) {
            self.add(section, V1, true, bytes);
        }
        Ok(())
    }
}

/// The bytes of a metadata value.
fn encode(value: &impl Serialize) -> Vec<u8> {
    // The structs have no maps or unsized sequences, and a vector grows: the only errors
    // that postcard could report cannot occur.
    append(Vec::new(), value).unwrap_or_default()
}
