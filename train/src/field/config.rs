//! The shape of a trainable field.

use pocketnerf_core::encoding::{HashGridConfig, spherical_harmonics};
use pocketnerf_core::field::Shading;

use super::NerfConfig;

/// How positions are encoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EncodingConfig {
    /// Multiresolution hash grid, trained.
    HashGrid(HashGridConfig),
    /// The paper's field, which brings its own networks: nothing else of a
    /// [`FieldConfig`] is read.
    Nerf(NerfConfig),
}

impl EncodingConfig {
    /// Values that the encoding gives for a point.
    #[must_use]
    pub fn n_output(&self) -> usize {
        match self {
            Self::HashGrid(config) => config.n_output(),
            Self::Nerf(config) => config.positions.n_output(),
        }
    }
}

/// The shape of a trainable field.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldConfig {
    /// Position encoding.
    pub encoding: EncodingConfig,
    /// Widths of the density network's hidden layers.
    pub density_hidden: Vec<usize>,
    /// Widths of the colour network's hidden layers.
    pub color_hidden: Vec<usize>,
    /// Features that the density network gives to the colour network.
    pub n_features: usize,
    /// Degree of the spherical harmonics of the direction; 1: no view dependence.
    pub sh_degree: u32,
    /// When colour is computed.
    pub shading: Shading,
    /// Carries the unit of length, see `Decoder::log_density_bias`.
    pub log_density_bias: f32,
}

impl FieldConfig {
    /// Widths of the density network, from input to output.
    #[must_use]
    pub fn density_widths(&self) -> Vec<usize> {
        let ends = (self.encoding.n_output(), 1 + self.n_features);
        widths(ends.0, &self.density_hidden, ends.1)
    }

    /// Widths of the colour network, from input to output.
    #[must_use]
    pub fn color_widths(&self) -> Vec<usize> {
        let n_input = self.n_features + spherical_harmonics::n_output(self.sh_degree);
        widths(n_input, &self.color_hidden, 3)
    }
}

fn widths(input: usize, hidden: &[usize], output: usize) -> Vec<usize> {
    [&[input], hidden, &[output]].concat()
}
