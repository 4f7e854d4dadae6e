//! Where each tensor of a field lies in the flat parameter buffer.

use pocketnerf_core::encoding::{HashGrid, MAX_LEVELS};
use pocketnerf_core::field::{Decoder, HashGridField};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{AnyField, DType, Error, Layout as Order, TensorView};

use super::rounding::Half;
use super::{EncodingConfig, FieldConfig, NerfPart, Rounded};

/// What a range of parameters is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// Table of a hash grid's level.
    GridLevel(usize),
    /// Weights of a layer of the density network.
    DensityWeight(usize),
    /// Its biases.
    DensityBias(usize),
    /// Weights of a layer of the colour network.
    ColorWeight(usize),
    /// Its biases.
    ColorBias(usize),
    /// A part of the paper's field.
    Nerf(NerfPart),
}

/// A named range of the flat buffer, row-major `[rows, cols]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// What it is.
    pub part: Part,
    /// First value.
    pub start: usize,
    /// Shape.
    pub shape: [usize; 2],
}

impl Range {
    /// Values in the range.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.shape[0] * self.shape[1]
    }

    /// Whether the range holds nothing.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The indices of its values.
    #[must_use]
    pub const fn indices(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.len()
    }
}

/// All ranges of a field: grid levels first, then the networks.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    ranges: Vec<Range>,
    n_levels: usize,
}

impl Layout {
    /// Lays out the parameters of `config`.
    #[must_use]
    pub fn new(config: &FieldConfig) -> Self {
        let mut layout = Self { ranges: Vec::new(), n_levels: 0 };
        if let EncodingConfig::HashGrid(grid) = &config.encoding {
            layout.n_levels = grid.n_levels as usize;
            for level in 0..layout.n_levels {
                let rows = grid.level(level).entries as usize;
                layout.push(Part::GridLevel(level), [rows, grid.n_features_per_level as usize]);
            }
        }
        if let EncodingConfig::Nerf(nerf) = &config.encoding {
            nerf.parts(|part, shape| layout.push(Part::Nerf(part), shape));
            return layout;
        }
        for (i, pair) in config.density_widths().windows(2).enumerate() {
            layout.push(Part::DensityWeight(i), [pair[0], pair[1]]);
            layout.push(Part::DensityBias(i), [1, pair[1]]);
        }
        for (i, pair) in config.color_widths().windows(2).enumerate() {
            layout.push(Part::ColorWeight(i), [pair[0], pair[1]]);
            layout.push(Part::ColorBias(i), [1, pair[1]]);
        }
        layout
    }

    fn push(&mut self, part: Part, shape: [usize; 2]) {
        let start = self.len();
        self.ranges.push(Range { part, start, shape });
    }

    /// Number of parameters.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ranges.last().map_or(0, |r| r.start + r.len())
    }

    /// Whether there are no parameters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All ranges in order.
    #[must_use]
    pub fn ranges(&self) -> &[Range] {
        &self.ranges
    }

    /// The ranges of the grid's levels.
    #[must_use]
    pub fn levels(&self) -> &[Range] {
        &self.ranges[..self.n_levels]
    }

    /// The ranges of the networks, weight and bias by turns.
    #[must_use]
    pub fn networks(&self) -> &[Range] {
        &self.ranges[self.n_levels..]
    }

    /// Where the networks' parameters begin.
    #[must_use]
    pub fn networks_start(&self) -> usize {
        self.networks()[0].start
    }

    /// The range of a part, which must exist.
    #[must_use]
    pub fn range(&self, part: Part) -> Range {
        *self.ranges.iter().find(|r| r.part == part).expect("a part of this layout")
    }

    /// A field that reads `parameters`, for core to evaluate.
    ///
    /// # Errors
    /// Whatever core's validation reports.
    pub fn view<'a>(
        &self,
        config: &FieldConfig,
        parameters: &'a [f32],
    ) -> Result<AnyField<'a>, Error> {
        self.view_with(config, |range| {
            let bytes = bytemuck::must_cast_slice(&parameters[range.indices()]);
            let shape = range.shape.map(|n| n as u32);
            TensorView::new(bytes, DType::F32, shape, 0, Order::RowMajor)
        })
    }

    /// The same from rounded parameters.
    ///
    /// # Errors
    /// Whatever core's validation reports.
    pub fn view_rounded<'a>(
        &self,
        config: &FieldConfig,
        rounded: &'a Rounded,
    ) -> Result<AnyField<'a>, Error> {
        let start = self.networks_start();
        self.view_with(config, |range| {
            let shape = range.shape.map(|n| n as u32);
            let (bytes, dtype, scale_log2) = match range.part {
                Part::GridLevel(level) => (
                    &rounded.tables[range.indices()],
                    DType::I8,
                    rounded.scales[level].scale_log2(),
                ),
                _ => {
                    let values = &rounded.networks[range.start - start..][..range.len()];
                    (bytemuck::must_cast_slice(values), DType::F16, Half::SCALE_LOG2)
                }
            };
            TensorView::new(bytes, dtype, shape, scale_log2, Order::RowMajor)
        })
    }

    fn view_with<'a>(
        &self,
        config: &FieldConfig,
        tensor: impl Fn(&Range) -> Result<TensorView<'a>, Error>,
    ) -> Result<AnyField<'a>, Error> {
        if let EncodingConfig::Nerf(nerf) = &config.encoding {
            let view = |part| tensor(&self.range(Part::Nerf(part)));
            let field = AnyField::Nerf(nerf.view(view)?);
            field.validate()?;
            return Ok(field);
        }
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        for (level, range) in levels.iter_mut().zip(self.levels()) {
            *level = tensor(range)?;
        }
        let network = |ranges: &[Range]| {
            let layers: Result<Vec<_>, Error> = ranges
                .chunks_exact(2)
                .map(|pair| Ok(Dense { weight: tensor(&pair[0])?, bias: Some(tensor(&pair[1])?) }))
                .collect();
            Mlp::new(&layers?)
        };
        let (density, color) = self.networks().split_at(2 * (config.density_hidden.len() + 1));
        let decoder = Decoder {
            density: network(density)?,
            color: network(color)?,
            n_features: config.n_features as u32,
            sh_degree: config.sh_degree,
            shading: config.shading,
            log_density_bias: config.log_density_bias,
        };
        let field = match config.encoding {
            EncodingConfig::HashGrid(config) => {
                AnyField::HashGrid(HashGridField { grid: HashGrid { config, levels }, decoder })
            }
            EncodingConfig::Nerf(_) => unreachable!("laid out above"),
        };
        field.validate()?;
        Ok(field)
    }
}
