//! From bytes to a model.

#[cfg(feature = "hash-grid")]
use pocketnerf_core::encoding::HashGrid;
use pocketnerf_core::encoding::MAX_LEVELS;
use pocketnerf_core::field::Decoder;
#[cfg(feature = "frequency")]
use pocketnerf_core::field::FrequencyField;
#[cfg(feature = "hash-grid")]
use pocketnerf_core::field::HashGridField;
use pocketnerf_core::network::{Dense, MAX_LAYERS, Mlp};
use pocketnerf_core::{AnyField, Model, Occupancy, TensorView};

use crate::FormatError;
use crate::about::About;
use crate::container::Container;
use crate::metadata::field::{DecoderConfig, EncodingConfig, read_field};
use crate::metadata::widths::Widths;
use crate::metadata::{Fields, V1, about, space};
use crate::section::{RAW, Section, SectionId, kind};
use crate::tensors::{TensorName, Tensors, tensors};

/// An opened file. Everything in it borrows the bytes that were opened.
#[derive(Clone, Copy, Debug)]
pub struct ModelFile<'a> {
    /// The model, ready to render; [`Model::validate`] has passed.
    pub model: Model<'a>,
    /// Dataset coordinates, default camera and origin.
    pub about: About<'a>,
    container: Container<'a>,
}

/// Opens a `.pnerf` file that lies in memory, at any alignment, without
/// copying: structure, bounds, the checksums of header and metadata, and
/// whether the parts make a model. O(sections), and two bytes read for every
/// 512 cells of occupancy; the weights are not touched.
///
/// An unverified weight may be infinite or NaN; rendering such a model gives
/// wrong colours, never a hang. [`open_verified`] looks at every byte.
///
/// # Errors
/// What was found and what was expected; see [`FormatError`].
pub fn open(bytes: &[u8]) -> Result<ModelFile<'_>, FormatError> {
    ModelFile::from_container(Container::open(bytes)?)
}

/// [`open`], then [`ModelFile::verify`].
///
/// # Errors
/// See [`FormatError`].
pub fn open_verified(bytes: &[u8]) -> Result<ModelFile<'_>, FormatError> {
    let file = open(bytes)?;
    file.verify()?;
    Ok(file)
}

impl<'a> ModelFile<'a> {
    /// Finds the model in a container, which may hold other things as well.
    ///
    /// # Errors
    /// Those of [`open`].
    pub fn from_container(container: Container<'a>) -> Result<Self, FormatError> {
        for section in container.sections() {
            is_usable(&section)?;
        }
        let (encoding, config) = read_field(required(&container, kind::FIELD)?)?;
        let tensors = Tensors::read(&container, required(&container, kind::TENSORS)?)?;
        let decoder = decoder(&config, &tensors)?;
        let field = field(encoding, decoder, &tensors)?;
        let (mut display, camera) = about::read_display(required(&container, kind::DISPLAY)?)?;
        if let Some(fields) = optional(&container, kind::DETAIL)? {
            display.tolerance = about::read_detail(fields)?;
        }
        let model = Model {
            field,
            space: space::read_space(required(&container, kind::SPACE)?)?,
            occupancy: occupancy(&container)?,
            sampling: space::read_sampling(required(&container, kind::SAMPLING)?)?,
            hierarchical: None,
            display,
        };
        model.validate()?;
        let scene = optional(&container, kind::SCENE)?.map(about::read_scene).transpose()?;
        let about = About {
            scene: scene.unwrap_or_default(),
            camera,
            provenance: optional(&container, kind::PROVENANCE)?
                .map(about::read_provenance)
                .transpose()?,
        };
        Ok(Self { model, about, container })
    }

    /// Checks the checksum of every section, the padding between them, and that
    /// every weight is finite. O(bytes).
    ///
    /// # Errors
    /// [`FormatError::Checksum`], [`FormatError::Padding`] or
    /// [`FormatError::NotFinite`].
    pub fn verify(&self) -> Result<(), FormatError> {
        self.container.verify()?;
        match self.tensors().find(|(_, view)| !view.is_finite()) {
            Some((name, _)) => Err(FormatError::NotFinite(name)),
            None => Ok(()),
        }
    }

    /// The file as sections, for listing them or finding a program's own.
    #[must_use]
    pub const fn container(&self) -> Container<'a> {
        self.container
    }

    /// The sections in the order of the file.
    pub fn sections(&self) -> impl ExactSizeIterator<Item = Section<'a>> + use<'a> {
        self.container.sections()
    }

    /// The weights in the order of the file.
    pub fn tensors(&self) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + '_ {
        tensors(&self.model.field)
    }
}

/// Whether this build understands a section: kind, version and encoding.
/// Not to understand a critical one is an error.
fn is_usable(section: &Section<'_>) -> Result<bool, FormatError> {
    let id = section.id;
    let error = if kind::name(id.kind).is_none() {
        FormatError::UnknownSection(id)
    } else if section.version != V1 {
        FormatError::UnknownVersion { section: id, found: section.version }
    } else if section.encoding != RAW {
        FormatError::UnknownEncoding { section: id, found: section.encoding }
    } else {
        return Ok(true);
    };
    if section.is_critical() { Err(error) } else { Ok(false) }
}

/// The section, where it is there and understood.
fn find<'a>(container: &Container<'a>, id: SectionId) -> Result<Option<Section<'a>>, FormatError> {
    match container.find(id) {
        Some(section) if is_usable(&section)? => Ok(Some(section)),
        _ => Ok(None),
    }
}

/// The section, or the error that it is missing.
pub(crate) fn need<'a>(
    container: &Container<'a>,
    id: SectionId,
) -> Result<Section<'a>, FormatError> {
    find(container, id)?.ok_or(FormatError::Missing(id))
}

fn optional<'a>(container: &Container<'a>, kind: u32) -> Result<Option<Fields<'a>>, FormatError> {
    find(container, SectionId::first(kind))?.as_ref().map(Fields::open).transpose()
}

fn required<'a>(container: &Container<'a>, kind: u32) -> Result<Fields<'a>, FormatError> {
    Fields::open(&need(container, SectionId::first(kind))?)
}

fn occupancy<'a>(container: &Container<'a>) -> Result<Option<Occupancy<'a>>, FormatError> {
    let Some(fields) = optional(container, kind::OCCUPANCY)? else { return Ok(None) };
    let size = space::read_occupancy(fields)?;
    let coarse = need(container, SectionId::first(kind::OCC_COARSE))?.bytes;
    let fine = need(container, SectionId::first(kind::OCC_FINE))?.bytes;
    Ok(Some(Occupancy::new(size.resolution, size.n_cascades, coarse, fine)?))
}

fn field<'a>(
    encoding: EncodingConfig,
    decoder: Decoder<'a>,
    tensors: &Tensors<'a>,
) -> Result<AnyField<'a>, FormatError> {
    let n_levels = match encoding {
        #[cfg(feature = "hash-grid")]
        EncodingConfig::HashGrid(config) => config.n_levels,
        #[cfg(feature = "frequency")]
        EncodingConfig::Frequency(_) => 0,
    };
    let mut levels = [TensorView::EMPTY; MAX_LEVELS];
    for ((l, level), table) in (0..).zip(&mut levels).zip(&tensors.grid) {
        match (table, l < n_levels) {
            (Some(table), true) => *level = *table,
            (None, true) => return Err(FormatError::MissingTensor(TensorName::GridLevel(l))),
            (Some(_), false) => {
                return Err(FormatError::UnexpectedTensor(TensorName::GridLevel(l)));
            }
            (None, false) => {}
        }
    }
    Ok(match encoding {
        #[cfg(feature = "hash-grid")]
        EncodingConfig::HashGrid(config) => {
            AnyField::HashGrid(HashGridField { grid: HashGrid { config, levels }, decoder })
        }
        #[cfg(feature = "frequency")]
        EncodingConfig::Frequency(encoding) => {
            AnyField::Frequency(FrequencyField { encoding, decoder })
        }
    })
}

fn decoder<'a>(config: &DecoderConfig, tensors: &Tensors<'a>) -> Result<Decoder<'a>, FormatError> {
    Ok(Decoder {
        density: network(
            &config.density,
            (&tensors.density_weight, TensorName::DensityWeight),
            (&tensors.density_bias, TensorName::DensityBias),
        )?,
        color: network(
            &config.color,
            (&tensors.color_weight, TensorName::ColorWeight),
            (&tensors.color_bias, TensorName::ColorBias),
        )?,
        n_features: config.n_features,
        sh_degree: config.sh_degree,
        shading: config.shading,
        log_density_bias: config.log_density_bias,
    })
}

/// The tensors of one role, and what a tensor of that role is called.
type Role<'t, 'a> = (&'t [Option<TensorView<'a>>; MAX_LAYERS], fn(u32) -> TensorName);

/// Builds a network of the stated widths from the tensors of its two roles.
fn network<'a>(
    widths: &Widths,
    (weights, weight_name): Role<'_, 'a>,
    (biases, bias_name): Role<'_, 'a>,
) -> Result<Mlp<'a>, FormatError> {
    let mut layers = [Dense::EMPTY; MAX_LAYERS];
    let mut n_layers = 0;
    for (i, ((weight, bias), layer)) in (0..).zip(weights.iter().zip(biases).zip(&mut layers)) {
        let Some(shape) = widths.layer(i as usize) else {
            // The field ends here, so the directory must as well.
            for (extra, name) in [(weight, weight_name), (bias, bias_name)] {
                if extra.is_some() {
                    return Err(FormatError::UnexpectedTensor(name(i)));
                }
            }
            continue;
        };
        let weight = weight.ok_or(FormatError::MissingTensor(weight_name(i)))?;
        expect_shape(weight_name(i), &weight, shape)?;
        if let Some(bias) = bias {
            expect_shape(bias_name(i), bias, [1, shape[1]])?;
        }
        *layer = Dense { weight, bias: *bias };
        n_layers += 1;
    }
    Ok(Mlp::new(&layers[..n_layers])?)
}

fn expect_shape(
    tensor: TensorName,
    view: &TensorView<'_>,
    expected: [u32; 2],
) -> Result<(), FormatError> {
    let found = view.shape();
    if found == expected {
        Ok(())
    } else {
        Err(FormatError::TensorShape { tensor, expected, found })
    }
}
