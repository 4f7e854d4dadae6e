//! From an encoded point to density and colour: the part that the field kinds
//! share.

use crate::Error;
use crate::encoding::spherical_harmonics;
use crate::field::MAX_CHANNELS;
use crate::network::Mlp;

/// When view-dependent colour is computed.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// For every sample; the ray accumulates three colours.
    PerSample,
    /// Once a ray ("deferred"): the ray accumulates features, and the colour
    /// network reads their average. Much cheaper.
    PerRay,
}

/// Density network and colour network.
///
/// `density` reads the encoded point and gives `1 + n_features` values: value 0
/// is the logarithm of the density, the rest are features.
/// `color` reads `[features, harmonics(direction)]` and gives three values;
/// their logistic is the colour.
#[derive(Clone, Copy, Debug)]
pub struct Decoder<'a> {
    /// Encoded point to log density and features.
    pub density: Mlp<'a>,
    /// Features and direction to colour.
    pub color: Mlp<'a>,
    /// Features that the colour network reads.
    pub n_features: u32,
    /// Degree of the spherical harmonics of the direction, 1 to 4; 1 is
    /// independent of the view.
    pub sh_degree: u32,
    /// When colour is computed.
    pub shading: Shading,
    /// Added to the log density: `sigma = exp(min(raw + log_density_bias, 15))`,
    /// in 1 / scene unit. It carries the unit of length.
    pub log_density_bias: f32,
}

/// Log densities are cut off here, so that sigma stays finite.
pub const MAX_LOG_DENSITY: f32 = 15.0;

impl Decoder<'_> {
    /// Checks that networks, features and encoding fit together; `n_encoded` is
    /// what the position encoding gives.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn validate(&self, n_encoded: usize) -> Result<(), Error> {
        let n_features = self.n_features as usize;
        if n_features == 0 || n_features > MAX_CHANNELS {
            return Err(Error::Range("number of features"));
        }
        if !(1..=spherical_harmonics::MAX_DEGREE).contains(&self.sh_degree) {
            return Err(Error::Range("degree of the spherical harmonics"));
        }
        if !(self.log_density_bias.abs() < 64.0) {
            return Err(Error::Range("log density bias"));
        }
        if self.density.n_input() != n_encoded {
            return Err(Error::Shape("position encoding and density network"));
        }
        if self.density.n_output() != 1 + n_features {
            return Err(Error::Shape("density network and number of features"));
        }
        if self.color.n_input() != n_features + spherical_harmonics::n_output(self.sh_degree) {
            return Err(Error::Shape("colour network and its inputs"));
        }
        if self.color.n_output() != 3 {
            return Err(Error::Shape("colour network: three outputs"));
        }
        if self.color.layers()[0].weight.dtype() != self.density.layers()[0].weight.dtype() {
            return Err(Error::Shape("networks of different types"));
        }
        Ok(())
    }

    /// Values that a ray accumulates: K.
    #[must_use]
    pub const fn channels(&self) -> usize {
        match self.shading {
            Shading::PerSample => 3,
            Shading::PerRay => self.n_features as usize,
        }
    }
}
