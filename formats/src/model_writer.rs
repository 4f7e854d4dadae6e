//! From a model to bytes.

use alloc::vec::Vec;

#[cfg(feature = "hash-grid")]
use pocketnerf_core::field::Decoder;
use pocketnerf_core::{AnyField, DType, Display, Layout, Model, TensorView};

use crate::ModelFile;
use crate::about::{About, PixelOrigin};
use crate::directory::write_directory;
#[cfg(feature = "hash-grid")]
use crate::metadata::decoder::DecoderConfig;
use crate::metadata::field::{FieldConfig, write_field};
#[cfg(feature = "nerf")]
use crate::metadata::nerf::NerfV1;
#[cfg(feature = "hash-grid")]
use crate::metadata::widths::Widths;
use crate::metadata::{V1, about, encode, space};
use crate::section::{SectionId, kind};
use crate::tensors::{TensorName, tensors};
use crate::writer::{ContainerWriter, WriteError};
use crate::{FormatError, eight_bits, f16, reader};

/// How weights are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// As they are.
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
/// [`WriteError`]; what [`open`](crate::open) would refuse is never written.
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

/// The file again with this [quality](About::quality); every other section stays as it
/// is, those of other programs too.
///
/// # Errors
/// [`WriteError::Unsupported`] for a quality outside 0 to 1.
pub fn with_quality(file: &ModelFile<'_>, quality: f32) -> Result<Vec<u8>, WriteError> {
    let mut writer = ContainerWriter::new();
    for section in file.sections().filter(|section| section.id.kind != kind::QUALITY) {
        writer.add(section.id, section.version, section.is_critical(), section.bytes);
    }
    writer.add_quality(quality)?;
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
        self.metadata(kind::SCENE, about::write_scene(&about.scene));
        let bytes = space::write_space(&model.space).ok_or(WriteError::Unsupported("space"))?;
        self.metadata(kind::SPACE, bytes);
        self.metadata(kind::SAMPLING, space::write_sampling(&model.sampling));
        let config = config(&model.field).ok_or(WriteError::Unsupported("field"))?;
        let bytes = write_field(&config).ok_or(WriteError::Unsupported("field"))?;
        self.metadata(kind::FIELD, bytes);
        let bytes = about::write_display(&model.display, about.camera.as_ref())
            .ok_or(WriteError::Unsupported("colour space"))?;
        self.metadata(kind::DISPLAY, bytes);
        // Readers may skip what they do not know of these.
        if model.display.tolerance != Display::TOLERANCE {
            let bytes = about::write_detail(model.display.tolerance);
            self.add(SectionId::first(kind::DETAIL), V1, false, bytes);
        }
        if about.pixel_origin != PixelOrigin::Center {
            let bytes = about::write_pixels(about.pixel_origin);
            self.add(SectionId::first(kind::PIXELS), V1, false, bytes);
        }
        if let Some(quality) = about.quality {
            self.add_quality(quality)?;
        }
        if let Some(hierarchical) = &model.hierarchical {
            let id = SectionId::first(kind::HIERARCHICAL);
            self.add(id, V1, false, space::write_hierarchical(hierarchical));
        }
        if let Some(provenance) = &about.provenance {
            let id = SectionId::first(kind::PROVENANCE);
            self.add(id, V1, false, about::write_provenance(provenance));
        }
        if let Some(occupancy) = &model.occupancy {
            let (resolution, n_cascades) = (occupancy.resolution(), occupancy.n_cascades());
            self.metadata(kind::OCCUPANCY, encode(&space::OccupancyV1 { resolution, n_cascades }));
            self.add(SectionId::first(kind::OCC_COARSE), V1, true, occupancy.coarse_bytes());
            self.add(SectionId::first(kind::OCC_FINE), V1, true, occupancy.fine_bytes());
        }
        self.add_tensors(&model.field, precision)
    }

    fn add_quality(&mut self, quality: f32) -> Result<(), WriteError> {
        if !(0.0..=1.0).contains(&quality) {
            return Err(WriteError::Unsupported("quality"));
        }
        self.add(SectionId::first(kind::QUALITY), V1, false, about::write_quality(quality));
        Ok(())
    }

    fn metadata(&mut self, kind: u32, bytes: Vec<u8>) {
        self.add(SectionId::first(kind), V1, true, bytes);
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
            // So few, and what is rounded here is other waves.
            let exact =
                matches!(name, TensorName::PositionFrequencies | TensorName::DirectionFrequencies);
            let (dtype, bytes, scale_log2) = match precision {
                _ if exact => (DType::F32, f16::to_f32(name, &view)?, 0),
                Precision::F32 => (DType::F32, f16::to_f32(name, &view)?, 0),
                Precision::I8 if matches!(name, TensorName::GridLevel(_)) => {
                    let (bytes, scale_log2) = eight_bits::to_i8(name, &view)?;
                    (DType::I8, bytes, scale_log2)
                }
                Precision::F16 | Precision::I8 => {
                    let (bytes, scale_log2) = f16::to_f16(name, &view)?;
                    (DType::F16, bytes, scale_log2)
                }
            };
            stored.push((name, view.shape(), dtype, scale_log2, bytes));
        }
        let mut n_network = 0;
        let mut directory = Vec::with_capacity(stored.len());
        for (name, shape, dtype, scale_log2, bytes) in &stored {
            let section = match *name {
                TensorName::GridLevel(index) => SectionId { kind: kind::GRID, index },
                _ => SectionId { kind: kind::NETWORK, index: n_network },
            };
            n_network += u32::from(section.kind == kind::NETWORK);
            let view = TensorView::new(bytes, *dtype, *shape, *scale_log2, Layout::RowMajor)
                .map_err(FormatError::Model)?;
            directory.push((*name, view, section));
        }
        let bytes = write_directory(directory.iter().copied())
            .ok_or(WriteError::Unsupported("tensor type"))?;
        self.metadata(kind::TENSORS, bytes);
        let sections: Vec<SectionId> = directory.iter().map(|(_, _, section)| *section).collect();
        for (section, (.., bytes)) in sections.into_iter().zip(stored) {
            self.add(section, V1, true, bytes);
        }
        Ok(())
    }
}

/// What FIELD says of a field; `None` for a kind that the format lacks.
fn config(field: &AnyField<'_>) -> Option<FieldConfig> {
    match field {
        #[cfg(feature = "hash-grid")]
        AnyField::HashGrid(field) => {
            Some(FieldConfig::HashGrid(field.grid.config, decoder(&field.decoder)?))
        }
        #[cfg(feature = "nerf")]
        AnyField::Nerf(field) => Some(FieldConfig::Nerf(NerfV1::of(field)?)),
        _ => None,
    }
}

#[cfg(feature = "hash-grid")]
fn decoder(decoder: &Decoder<'_>) -> Option<DecoderConfig> {
    Some(DecoderConfig {
        n_features: decoder.n_features,
        sh_degree: decoder.sh_degree,
        shading: decoder.shading,
        log_density_bias: decoder.log_density_bias,
        density: Widths::of(decoder.density.layers())?,
        color: Widths::of(decoder.color.layers())?,
    })
}
