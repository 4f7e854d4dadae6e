//! The shape of a hash grid and the networks behind it.

use pocketnerf_core::encoding::{
    GridIndex, HashGrid, HashGridConfig, MAX_LEVELS, spherical_harmonics,
};
use pocketnerf_core::field::{Decoder, HashGridField, Shading};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{Error, TensorView};

use crate::field::layout::{Layout, Part, Range, Role};

/// Names of the parts of the field.
pub(super) const GRID: &str = "grid";
pub(super) const DENSITY: &str = "density";
pub(super) const COLOR: &str = "color";

/// A multiresolution hash grid, a density network and a colour network.
#[derive(Clone, Debug, PartialEq)]
pub struct HashGridFieldConfig {
    /// Encoding of positions.
    pub grid: HashGridConfig,
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

impl Default for HashGridFieldConfig {
    fn default() -> Self {
        Self {
            grid: HashGridConfig {
                n_levels: 9,
                n_features_per_level: 4,
                log2_hashmap_size: 17,
                base_resolution: 16,
                per_level_scale: 1.65,
                index: GridIndex::Blocked,
            },
            density_hidden: vec![64],
            color_hidden: vec![64, 64],
            n_features: 15,
            sh_degree: 4,
            shading: Shading::PerRay,
        }
    }
}

impl HashGridFieldConfig {
    /// A small field that learns the outline of the same scene in a second.
    pub(in crate::field) fn coarse(&self) -> Self {
        Self {
            grid: HashGridConfig {
                n_levels: 5,
                n_features_per_level: 4,
                log2_hashmap_size: 14,
                base_resolution: 8,
                per_level_scale: 1.8,
                index: GridIndex::Blocked,
            },
            density_hidden: vec![32],
            color_hidden: vec![32],
            ..self.clone()
        }
    }

    /// The shape of a field.
    pub(in crate::field) fn of(field: &HashGridField<'_>) -> Self {
        let HashGridField { grid, decoder } = field;
        Self {
            grid: grid.config,
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

    /// Where each tensor lies: the grid's levels, then both networks.
    #[must_use]
    pub fn layout(&self) -> Layout {
        let mut layout = Layout::default();
        for level in 0..self.grid.n_levels as usize {
            let rows = self.grid.level(level).entries as usize;
            let part = Part { network: GRID, layer: level, role: Role::Table };
            layout.push(part, [rows, self.grid.n_features_per_level as usize]);
        }
        for (network, widths) in [(DENSITY, self.density_widths()), (COLOR, self.color_widths())] {
            for (layer, pair) in widths.windows(2).enumerate() {
                layout.push(Part { network, layer, role: Role::Weight }, [pair[0], pair[1]]);
                layout.push(Part { network, layer, role: Role::Bias }, [1, pair[1]]);
            }
        }
        layout
    }

    /// The field of the tensors of a layout.
    pub(super) fn view<'a>(
        &self,
        layout: &Layout,
        log_density_bias: f32,
        tensor: impl Fn(&Range) -> Result<TensorView<'a>, Error>,
    ) -> Result<HashGridField<'a>, Error> {
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        for (level, range) in levels.iter_mut().zip(layout.tables()) {
            *level = tensor(range)?;
        }
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
        Ok(HashGridField { grid: HashGrid { config: self.grid, levels }, decoder })
    }
}

/// Widths of a network's hidden layers.
fn hidden(network: &Mlp<'_>) -> Vec<usize> {
    let widths = network.layers().iter().map(|layer| layer.weight.cols());
    widths.take(network.layers().len().saturating_sub(1)).collect()
}
