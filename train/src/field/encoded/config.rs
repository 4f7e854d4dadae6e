//! The shape of an encoding and the networks behind it.

use pocketnerf_core::encoding::{GridIndex, HashGridConfig, spherical_harmonics};
use pocketnerf_core::field::{Decoder, Shading};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{Error, TensorView};

use super::Encoding;
use crate::field::HashGridFieldConfig;
use crate::field::layout::{Layout, Part, Range, Role};

/// Names of the parts of the field.
pub(super) const GRID: &str = "grid";
pub(super) const DENSITY: &str = "density";
pub(super) const COLOR: &str = "color";

/// An encoding with tables, a density network and a colour network.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedFieldConfig<E> {
    /// Encoding of positions.
    pub grid: E,
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
}

/// A small hash grid that learns the outline of a scene in a second.
const COARSE: HashGridConfig = HashGridConfig {
    n_levels: 5,
    n_features_per_level: 4,
    log2_hashmap_size: 14,
    base_resolution: 8,
    per_level_scale: 1.8,
    index: GridIndex::Blocked,
};

impl<E: Encoding> EncodedFieldConfig<E> {
    /// A small field that learns the outline of the same scene in a second.
    pub(in crate::field) fn coarse(&self) -> HashGridFieldConfig {
        HashGridFieldConfig {
            grid: COARSE,
            density_hidden: vec![32],
            color_hidden: vec![32],
            n_features: self.n_features,
            sh_degree: self.sh_degree,
            shading: self.shading,
        }
    }

    /// The shape of an encoding and the networks behind it.
    pub(in crate::field) fn with(grid: E, decoder: &Decoder<'_>) -> Self {
        Self {
            grid,
            density_hidden: hidden(&decoder.density),
            color_hidden: hidden(&decoder.color),
            n_features: decoder.n_features as usize,
            sh_degree: decoder.sh_degree,
            shading: decoder.shading,
        }
    }

    /// Widths of the density network, from input to output.
    #[must_use]
    pub fn density_widths(&self) -> Vec<usize> {
        [&[self.grid.n_output()][..], &self.density_hidden, &[1 + self.n_features]].concat()
    }

    /// Widths of the colour network, from input to output.
    #[must_use]
    pub fn color_widths(&self) -> Vec<usize> {
        let n_input = self.n_features + spherical_harmonics::n_output(self.sh_degree);
        [&[n_input][..], &self.color_hidden, &[3]].concat()
    }

    /// Where each tensor lies: the encoding's tables, then both networks.
    #[must_use]
    pub fn layout(&self) -> Layout {
        let mut layout = Layout::default();
        for (layer, shape) in self.grid.tables().into_iter().enumerate() {
            layout.push(Part { network: GRID, layer, role: Role::Table }, shape);
        }
        for (network, widths) in [(DENSITY, self.density_widths()), (COLOR, self.color_widths())] {
            for (layer, pair) in widths.windows(2).enumerate() {
                layout.push(Part { network, layer, role: Role::Weight }, [pair[0], pair[1]]);
                layout.push(Part { network, layer, role: Role::Bias }, [1, pair[1]]);
            }
        }
        layout
    }

    /// The encoding and the networks of the tensors of a layout.
    pub(super) fn view<'a>(
        &self,
        layout: &Layout,
        log_density_bias: f32,
        tensor: impl Fn(&Range) -> Result<TensorView<'a>, Error>,
    ) -> Result<(E::View<'a>, Decoder<'a>), Error> {
        let network = |ranges: &[Range]| {
            let layers: Result<Vec<_>, Error> = ranges
                .chunks_exact(2)
                .map(|pair| Ok(Dense { weight: tensor(&pair[0])?, bias: Some(tensor(&pair[1])?) }))
                .collect();
            Mlp::new(&layers?)
        };
        let (density, color) = layout.networks().split_at(2 * (self.density_hidden.len() + 1));
        let decoder = Decoder {
            density: network(density)?,
            color: network(color)?,
            n_features: self.n_features as u32,
            sh_degree: self.sh_degree,
            shading: self.shading,
            log_density_bias,
        };
        Ok((self.grid.view(layout.tables(), tensor)?, decoder))
    }
}

/// Widths of a network's hidden layers.
fn hidden(network: &Mlp<'_>) -> Vec<usize> {
    let widths = network.layers().iter().map(|layer| layer.weight.cols());
    widths.take(network.layers().len().saturating_sub(1)).collect()
}
