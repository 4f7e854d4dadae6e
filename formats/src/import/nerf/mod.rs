//! Vanilla NeRFs as other programs save them.
//!
//! [`Nerf::read`] knows the programs by the names of their tensors:
//!
//! | program | names | peculiarities |
//! |---|---|---|
//! | bmild/nerf (TensorFlow) | none: a list of kernels and biases | `[n_in, n_out]`; coarse and fine network are two files |
//! | yenchenlin/nerf-pytorch | `pts_linears.0.weight` | |
//! | krrish94/nerf-pytorch | `layer1.weight`, `layers_xyz.0.weight` | three models; ReLU and skip connections are elsewhere |
//! | kwea123/nerf_pl | `xyz_encoding_1.0.weight` | |
//!
//! and takes depth, widths, skip connections and octaves from the shapes. No file states
//! the rest, on which the programs agree: octaves 2^k without π, sine before cosine, the
//! input first; density by ReLU, colour by the logistic function; positions in scene
//! units.

mod dialects;
mod network;

use pocketnerf_core::Error;
use pocketnerf_core::encoding::{Affine, Fourier, Waves};
use pocketnerf_core::field::Field as _;
use pocketnerf_core::field::{Activation, NerfField};

use super::tensors::Tensors;
use super::{Checkpoint, FieldError};
use dialects::Dialect;
use network::Network;

/// What precedes the names of the coarse and of the fine network's tensors.
const PREFIXES: [[&str; 2]; 4] = [
    ["network_fn_state_dict.", "network_fine_state_dict."],
    ["model_coarse_state_dict.", "model_fine_state_dict."],
    ["state_dict.nerf_coarse.", "state_dict.nerf_fine."],
    ["nerf_coarse.", "nerf_fine."],
];

/// The networks of a vanilla NeRF, in f32 and in memory of their own.
#[derive(Clone, Debug)]
pub struct Nerf {
    program: &'static str,
    fine: Network,
    coarse: Option<Network>,
    positions: Fourier<'static>,
    directions: Option<Fourier<'static>>,
}

impl Nerf {
    /// Finds the networks in a checkpoint: a coarse and a fine one, or one alone.
    ///
    /// # Errors
    /// See [`FieldError`].
    pub fn read(checkpoint: &Checkpoint<'_>) -> Result<Self, FieldError> {
        for [coarse, fine] in PREFIXES {
            let coarse = network(checkpoint, coarse)?;
            let fine = network(checkpoint, fine)?;
            match (coarse, fine) {
                (Some(coarse), Some(fine)) => return Self::new(Some(coarse), fine),
                (Some(only), None) | (None, Some(only)) => return Self::new(None, only),
                (None, None) => {}
            }
        }
        match network(checkpoint, "")? {
            Some(only) => Self::new(None, only),
            None => Err(FieldError::unknown(checkpoint)),
        }
    }

    /// The networks of two checkpoints that hold one each, as bmild/nerf saves them.
    ///
    /// # Errors
    /// See [`FieldError`].
    pub fn read_both(coarse: &Checkpoint<'_>, fine: &Checkpoint<'_>) -> Result<Self, FieldError> {
        let one =
            |checkpoint| network(checkpoint, "")?.ok_or_else(|| FieldError::unknown(checkpoint));
        Self::new(Some(one(coarse)?), one(fine)?)
    }

    fn new(
        coarse: Option<(Dialect, Network)>,
        (dialect, fine): (Dialect, Network),
    ) -> Result<Self, FieldError> {
        let coarse = coarse.map(|(_, network)| network);
        let [n_position, n_direction] = fine.encoded;
        if let Some(coarse) = &coarse
            && coarse.encoded != fine.encoded
        {
            let found = coarse.encoded[usize::from(coarse.encoded[0] == n_position)];
            return Err(FieldError::Encoding { what: "position or direction, coarse", found });
        }
        let positions = octaves("position", n_position)?;
        let directions = match n_direction {
            0 => None,
            n => Some(octaves("direction", n)?),
        };
        Ok(Self { program: dialect.name(), fine, coarse, positions, directions })
    }

    /// The program that they come from.
    #[must_use]
    pub const fn program(&self) -> &'static str {
        self.program
    }

    /// Whether there is a coarse network beside the fine one.
    #[must_use]
    pub const fn has_coarse(&self) -> bool {
        self.coarse.is_some()
    }

    /// Leaves the coarse network out.
    pub fn drop_coarse(&mut self) {
        self.coarse = None;
    }

    /// The field, for a space whose unit coordinates `map` takes to the scene's.
    ///
    /// # Errors
    /// What core refuses: layers wider than it has room for.
    pub fn field(&self, map: Affine) -> Result<NerfField<'_>, Error> {
        let field = NerfField {
            positions: self.positions,
            directions: self.directions,
            map,
            activation: Activation::Relu,
            density_scale: 1.0,
            fine: self.fine.view()?,
            coarse: self.coarse.as_ref().map(Network::view).transpose()?,
        };
        field.validate()?;
        Ok(field)
    }
}

/// The network whose names begin so; `None` where there are no such names.
fn network(
    checkpoint: &Checkpoint<'_>,
    prefix: &str,
) -> Result<Option<(Dialect, Network)>, FieldError> {
    let Some(mut tensors) = Tensors::of(checkpoint, prefix) else { return Ok(None) };
    let Some(dialect) = Dialect::of(&tensors) else { return Ok(None) };
    let parts = dialect.parts(&mut tensors)?;
    tensors.finish()?;
    Network::new(parts).map(|network| Some((dialect, network)))
}

/// The octaves that give so many values.
fn octaves(what: &'static str, values: usize) -> Result<Fourier<'static>, FieldError> {
    let wrong = || FieldError::Encoding { what, found: values };
    let include_input = match values % 6 {
        0 if values > 0 => false,
        3 => true,
        _ => return Err(wrong()),
    };
    let n = u32::try_from(values / 6).map_err(|_| wrong())?;
    Ok(Fourier { waves: Waves::Octaves { n, pi: false }, include_input })
}
