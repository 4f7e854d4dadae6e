//! Networks of vanilla NeRF, as a model.

use pocketnerf_core::encoding::Affine;
use pocketnerf_core::space::Ndc;
use pocketnerf_core::{AnyField, ColorSpace, Display, Model, Sampling, SimdLevel, Space};
use pocketnerf_formats::PixelOrigin;
use pocketnerf_formats::import::nerf::Nerf;

use super::bake::Baker;
use super::settings::Complete;
use super::{ConvertError, Settings};
use crate::trainer::DensityGrid;

/// Samples along the longest side of the box.
const SAMPLES_PER_SIDE: f32 = 384.0;
/// A ray ends below this transmittance.
const MIN_TRANSMITTANCE: f32 = 1e-4;

/// Where a source's scene is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// In this box, smallest and largest corner.
    Box([[f32; 3]; 2]),
    /// In these coordinates.
    Ndc(Ndc),
}

/// The networks of vanilla NeRF, where their scene is and which cells it fills.
#[derive(Debug)]
pub struct NerfConversion {
    nerf: Nerf,
    complete: Complete,
    space: Space,
    cells: DensityGrid,
}

impl NerfConversion {
    /// Finds out where the scene is and which cells it fills. `place` gets whether rays are
    /// those of normalised device coordinates. If it returns `None`, the scene is around the
    /// origin, as wide as `near` and `far` are apart: what cameras between them see.
    ///
    /// # Errors
    /// [`ConvertError::Missing`] and what else is wrong with the settings;
    /// [`ConvertError::Empty`] if the field is empty.
    pub fn new(
        nerf: Nerf,
        settings: Settings,
        place: impl FnOnce(bool) -> Result<Option<Place>, ConvertError>,
        simd: SimdLevel,
    ) -> Result<Self, ConvertError> {
        let complete = settings.complete()?;
        let place = place(complete.ndc)?;
        let level = simd.token()?;
        let space = match place {
            Some(Place::Ndc(ndc)) => Space::Ndc(ndc),
            Some(Place::Box([min, max])) => Space::Box { min, max },
            None => found(&nerf, 0.5 * (complete.far - complete.near), level)?,
        };
        space.validate()?;
        let field = AnyField::Nerf(nerf.field(map(&space))?);
        let cells = Baker { field: &field, level, seed: 0, step: step(&space) }.cells(&space);
        Ok(Self { nerf, complete, space, cells })
    }

    /// The model, with cells and the source's own sampling.
    ///
    /// # Errors
    /// What core refuses.
    pub fn model(&self) -> Result<Model<'_>, ConvertError> {
        let Complete { near, far, hierarchical, background, .. } = self.complete;
        let scale = self.space.unit_map().scale;
        let in_ndc = matches!(self.space, Space::Ndc(_));
        let model = Model {
            field: AnyField::Nerf(self.nerf.field(map(&self.space))?),
            space: self.space,
            occupancy: Some(self.cells.grown()),
            sampling: Sampling {
                step: step(&self.space),
                near,
                // Rays end with the box.
                far: if in_ndc { near + 64.0 / scale } else { far },
                min_transmittance: MIN_TRANSMITTANCE,
            },
            hierarchical: Some(hierarchical),
            display: Display {
                background,
                color_space: ColorSpace::Srgb,
                tolerance: Display::TOLERANCE,
            },
        };
        model.validate()?;
        Ok(model)
    }

    /// Where the source's rays passed through pixels.
    #[must_use]
    pub const fn pixel_origin(&self) -> PixelOrigin {
        self.complete.pixel_origin
    }

    /// The program that wrote the checkpoint.
    #[must_use]
    pub const fn program(&self) -> &'static str {
        self.nerf.program()
    }

    /// The distance between the middle of the source's rays and their cameras, scene units.
    #[must_use]
    pub const fn distance(&self) -> f32 {
        0.5 * (self.complete.near + self.complete.far)
    }
}

/// The box around what is within `side` of the origin along each axis.
fn found(nerf: &Nerf, side: f32, level: fearless_simd::Level) -> Result<Space, ConvertError> {
    let around = [[-side; 3], [side; 3]];
    let [min, max] = around;
    let space = Space::Box { min, max };
    let field = AnyField::Nerf(nerf.field(map(&space))?);
    let baker = Baker { field: &field, level, seed: 0, step: step(&space) };
    let corners = baker.bounds(&space).ok_or(ConvertError::Empty(around))?;
    let [min, max] = corners.map(|u| u.map(|u| 2.0 * side * u - side));
    Ok(Space::Box { min, max })
}

/// Distance between samples in occupied cells, local units.
fn step(space: &Space) -> f32 {
    1.0 / (space.unit_map().scale * SAMPLES_PER_SIDE)
}

/// From unit coordinates to the local ones, which the networks read.
fn map(space: &Space) -> Affine {
    let map = space.unit_map();
    Affine { scale: [1.0 / map.scale; 3], offset: map.min }
}
