//! From bytes to a model.

use pocketnerf_core::march::Hierarchical;
use pocketnerf_core::{
    Camera, Error, Model, Occupancy, Probe, SimdLevel, TensorView, Tuning, math,
};

use crate::FormatError;
use crate::about::About;
use crate::container::{Container, RAW, Section, SectionId, kind};
use crate::directory::Listed;
use crate::metadata::field::{self, tensors};
use crate::metadata::{Fields, V1, about, photographs, space, world};
use crate::photographs::Photographs;
use crate::tensor_name::TensorName;

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
/// An unverified weight may be infinite or NaN; rendering such a model yields
/// wrong colours, never a hang. [`open_verified`] checks every byte.
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
    /// Finds the model in a container, which may hold other sections as well.
    ///
    /// # Errors
    /// Those of [`open`].
    pub fn from_container(container: Container<'a>) -> Result<Self, FormatError> {
        for section in container.sections() {
            is_usable(&section)?;
        }
        let field = field::read(required(&container, kind::FIELD)?, || {
            Listed::read(&container, required(&container, kind::TENSORS)?)
        })?;
        let (mut display, camera) = about::read_display(required(&container, kind::DISPLAY)?)?;
        if let Some(fields) = optional(&container, kind::DETAIL)? {
            display.tolerance = about::read_detail(fields)?;
        }
        let model = Model {
            field,
            space: space::read_space(required(&container, kind::SPACE)?)?,
            occupancy: occupancy(&container)?,
            sampling: space::read_sampling(required(&container, kind::SAMPLING)?)?,
            hierarchical: hierarchical(&container)?,
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
            pixel_origin: with_heap(&container, kind::PIXELS, about::read_pixels)?
                .unwrap_or_default(),
            quality: with_heap(&container, kind::QUALITY, about::read_quality)?,
            photographs: stored_photographs(&container)?,
            world: with_heap(&container, kind::WORLD, world::read)?.unwrap_or_default(),
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

    /// A camera that shows the model, in scene units: the file's own view, or, where it has
    /// none, one half a radian above the dataset's x axis, or above its y axis if x is up; of a
    /// forward-facing capture, one where the photographs were taken.
    #[must_use]
    pub fn camera(&self, width: u32, height: u32) -> Camera {
        if let Some(own) = self.about.camera {
            return Camera::from_fov_x(width, height, own.fov_x, own.camera_to_world);
        }
        let (space, scene) = (&self.model.space, &self.about.scene);
        #[cfg(feature = "ndc")]
        if let pocketnerf_core::Space::Ndc(ndc) = space {
            let pose = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
            let ahead = Camera::from_fov_x(width, height, 1.0, pose);
            return Camera { focal: [0.5 * width as f32 * ndc.slope[0]; 2], ..ahead };
        }
        let (middle, distance) = (space.center(), space.viewing_distance());
        let up = self.about.world.up();
        // Across it, towards the x axis.
        let axis = usize::from(up[0].abs() > 0.9);
        let length = math::sqrt(1.0 - up[axis] * up[axis]);
        let side = [0, 1, 2].map(|a| (f32::from(u8::from(a == axis)) - up[axis] * up[a]) / length);
        let [side, up] = [side, up].map(|axis| scene.to_model_direction(axis));
        let (sin, cos) = math::sin_cos(0.5);
        let eye = [0, 1, 2].map(|a| middle[a] + distance * (cos * side[a] + sin * up[a]));
        Camera::from_fov_x(width, height, 0.7, Camera::look_at(eye, middle, up))
    }

    /// Questions to the model, in the dataset's coordinates and units: SCENE's transform is
    /// applied.
    ///
    /// # Errors
    /// Those of [`Probe::new`] and [`Probe::with_similarity`].
    pub fn probe(&self, simd: SimdLevel, tuning: Tuning) -> Result<Probe<'_>, Error> {
        Probe::new(&self.model, simd, tuning)?.with_similarity(self.about.scene.similarity())
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

/// A section that builds without a heap ignore, as older builds do. Each would cost two
/// hundred bytes of code, and a microcontroller needs none of them.
fn with_heap<'a, T>(
    container: &Container<'a>,
    kind: u32,
    read: impl FnOnce(Fields<'a>) -> Result<T, FormatError>,
) -> Result<Option<T>, FormatError> {
    match cfg!(feature = "alloc") {
        true => optional(container, kind)?.map(read).transpose(),
        false => Ok(None),
    }
}

/// A web page has no paths, and would be a kilobyte larger.
fn stored_photographs<'a>(
    container: &Container<'a>,
) -> Result<Option<Photographs<'a>>, FormatError> {
    match cfg!(feature = "std") {
        true => optional(container, kind::PHOTOGRAPHS)?.map(photographs::read).transpose(),
        false => Ok(None),
    }
}

/// Builds without hierarchical sampling ignore its section, as older builds do.
fn hierarchical(container: &Container<'_>) -> Result<Option<Hierarchical>, FormatError> {
    match cfg!(feature = "nerf") {
        true => optional(container, kind::HIERARCHICAL)?.map(space::read_hierarchical).transpose(),
        false => Ok(None),
    }
}
