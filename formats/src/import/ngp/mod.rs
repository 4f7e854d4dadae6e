//! Hash grids as instant-ngp and its kin save them.
//!
//! [`Ngp::read`] knows the programs by the names of what they save:
//!
//! | program | names |
//! |---|---|
//! | NVlabs/instant-ngp | `snapshot.params_binary` |
//! | ashawkey/torch-ngp | `encoder.embeddings`, `sigma_net.0.weight` |
//! | kwea123/ngp_pl | `xyz_encoder.params`, `rgb_net.params` |
//! | nerfstudio, instant-ngp in a box | `pipeline._model.field.mlp_base.` |
//!
//! All of them give every sample a colour of its own: a density network reads the grid and
//! gives the logarithm of the density and features; a colour network reads those and the
//! direction's harmonics. They differ in the order of inputs and parameters, in how levels
//! are sized and in what is padded with what. None of that is left in the field: layers
//! are put into this library's order, what reads padding becomes a bias, and
//! [`GridIndex::Corners`](pocketnerf_core::encoding::GridIndex::Corners) lists the levels.

mod cells;
mod grid;
mod harmonics;
mod instant_ngp;
mod nerfstudio;
mod ngp_pl;
mod tcnn;
mod torch_ngp;

use std::vec::Vec;

use pocketnerf_core::field::Field as _;
use pocketnerf_core::field::{Decoder, HashGridField, Shading};
use pocketnerf_core::network::{Dense, MAX_LAYERS, Mlp};
use pocketnerf_core::{Camera, Error};

pub use cells::Cells;

use super::layer::{Layer, Stored};
use super::{Checkpoint, FieldError};
use crate::Scene;
use grid::Grid;

/// A hash grid with its networks, in f32 and in memory of its own, and the scene that the
/// checkpoint describes.
#[derive(Clone, Debug)]
pub struct Ngp {
    program: &'static str,
    grid: Grid,
    density: Vec<Stored>,
    color: Vec<Stored>,
    n_features: u32,
    sh_degree: u32,
    context: SceneContext,
}

/// The scene around a checkpoint's field, in the coordinates of its training.
#[derive(Clone, Debug)]
pub struct SceneContext {
    /// The box that is encoded, a cube: smallest and largest corner.
    pub bounds: [[f32; 3]; 2],
    /// The part of it that the program renders, if that is less.
    pub crop: Option<[[f32; 3]; 2]>,
    /// The map to the dataset's coordinates.
    pub scene: Scene<'static>,
    /// Distance between the program's samples.
    pub step: f32,
    /// Distance from the camera to the program's first sample.
    pub near: f32,
    /// A ray ends when its transmittance falls to this.
    pub min_transmittance: f32,
    /// Colour behind the scene, if the checkpoint has one.
    pub background: Option<[f32; 3]>,
    /// The occupied cells, if the checkpoint has them.
    pub cells: Option<Cells>,
    /// The training cameras, if the checkpoint has them. Without lenses.
    pub views: Vec<Camera>,
}

/// What the programs' readers find.
struct Parts {
    program: &'static str,
    grid: Grid,
    /// Its last layer gives the logarithm of the density, then the features.
    density: Vec<Layer>,
    /// Its first layer reads the features, then the harmonics of the direction.
    color: Vec<Layer>,
    sh_degree: u32,
    context: SceneContext,
}

/// Recognises a program's checkpoint, and reads it.
type Program = (fn(&Checkpoint<'_>) -> bool, fn(&Checkpoint<'_>) -> Result<Parts, FieldError>);

const PROGRAMS: [Program; 4] = [
    (instant_ngp::recognises, instant_ngp::read),
    (torch_ngp::recognises, torch_ngp::read),
    (ngp_pl::recognises, ngp_pl::read),
    (nerfstudio::recognises, nerfstudio::read),
];

impl Ngp {
    /// Whether the names are those of such a program. If so, [`Self::read`] reports what is
    /// wrong with the rest.
    #[must_use]
    pub fn recognises(checkpoint: &Checkpoint<'_>) -> bool {
        PROGRAMS.iter().any(|(recognises, _)| recognises(checkpoint))
    }

    /// Finds the field in a checkpoint.
    ///
    /// # Errors
    /// See [`FieldError`].
    pub fn read(checkpoint: &Checkpoint<'_>) -> Result<Self, FieldError> {
        match PROGRAMS.iter().find(|(recognises, _)| recognises(checkpoint)) {
            Some((_, read)) => Self::new(read(checkpoint)?),
            None => Err(FieldError::unknown(checkpoint)),
        }
    }

    fn new(parts: Parts) -> Result<Self, FieldError> {
        let Parts { program, grid, density, color, sh_degree, context } = parts;
        let most = density.len().max(color.len());
        if most > MAX_LAYERS {
            return Err(FieldError::Layers(most));
        }
        let n_features = density.last().map_or(0, |layer| layer.n_out.saturating_sub(1)) as u32;
        let [density, color] =
            [density, color].map(|layers| layers.iter().map(Layer::stored).collect());
        Ok(Self { program, grid, density, color, n_features, sh_degree, context })
    }

    /// The program that it comes from.
    #[must_use]
    pub const fn program(&self) -> &'static str {
        self.program
    }

    /// What the checkpoint says beside the field.
    #[must_use]
    pub const fn context(&self) -> &SceneContext {
        &self.context
    }

    /// What the checkpoint says, to be set right by what other files say.
    pub const fn context_mut(&mut self) -> &mut SceneContext {
        &mut self.context
    }

    /// The field, over the box of [`SceneContext::bounds`].
    ///
    /// # Errors
    /// What core refuses: layers that are wider than it has room for.
    pub fn field(&self) -> Result<HashGridField<'_>, Error> {
        let field = HashGridField {
            grid: self.grid.view()?,
            decoder: Decoder {
                density: network(&self.density)?,
                color: network(&self.color)?,
                n_features: self.n_features,
                sh_degree: self.sh_degree,
                shading: Shading::PerSample,
                log_density_bias: 0.0,
            },
        };
        field.validate()?;
        Ok(field)
    }
}

fn network(layers: &[Stored]) -> Result<Mlp<'_>, Error> {
    let mut views = [Dense::EMPTY; MAX_LAYERS];
    for (view, layer) in views.iter_mut().zip(layers) {
        *view = layer.view()?;
    }
    Mlp::new(&views[..layers.len()])
}
