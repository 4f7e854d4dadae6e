//! The networks of a vanilla NeRF (Mildenhall et al. 2020, figure 7).

use fearless_simd::Simd;

use crate::Error;
use crate::network::blocks::{Blocks, Row, dense_blocks};
use crate::network::{Dense, MAX_LAYERS, Mlp};

/// The networks of one field: `trunk` reads the encoded point; `density` and
/// `feature` read the trunk's output; `color` reads the feature, then the encoded
/// direction.
#[derive(Clone, Copy, Debug)]
pub struct NerfNetwork<'a> {
    trunk: [Dense<'a>; MAX_LAYERS],
    depth: usize,
    /// Bit i: layer i of the trunk reads the encoded point once more, before what the
    /// previous layer's output (a skip connection).
    pub skips: u16,
    /// Bit i: no ReLU after layer i of the trunk.
    pub linear: u16,
    /// `[width, 1]`: the density before its activation.
    pub density: Dense<'a>,
    /// `[width, n]`; `None`: the colour network reads the trunk.
    pub feature: Option<Dense<'a>>,
    /// Whether ReLU follows the feature. Not in the paper.
    pub feature_relu: bool,
    /// Feature and encoded direction to colour before the logistic. ReLU between layers.
    pub color: Mlp<'a>,
}

impl<'a> NerfNetwork<'a> {
    /// A network of these layers; [`Field::validate`](crate::field::Field::validate) checks that they fit together.
    /// `skips` and `linear` come together.
    ///
    /// # Errors
    /// [`Error::Range`] for too many layers in the trunk, or none.
    pub fn new(
        trunk: &[Dense<'a>],
        [skips, linear]: [u16; 2],
        density: Dense<'a>,
        feature: Option<Dense<'a>>,
        color: Mlp<'a>,
    ) -> Result<Self, Error> {
        if trunk.is_empty() || trunk.len() > MAX_LAYERS {
            return Err(Error::Range("network: number of layers"));
        }
        let mut all = [Dense::EMPTY; MAX_LAYERS];
        all[..trunk.len()].copy_from_slice(trunk);
        let depth = trunk.len();
        let feature_relu = false;
        Ok(Self { trunk: all, depth, skips, linear, density, feature, feature_relu, color })
    }

    /// The trunk, first layer to last.
    #[must_use]
    pub fn trunk(&self) -> &[Dense<'a>] {
        &self.trunk[..self.depth]
    }

    /// Whether layer `i` of the trunk reads the encoded point once more.
    #[must_use]
    pub const fn skips(&self, i: usize) -> bool {
        self.skips >> i & 1 == 1
    }

    /// Whether ReLU follows layer `i` of the trunk.
    #[must_use]
    pub const fn relu_after(&self, i: usize) -> bool {
        self.linear >> i & 1 == 0
    }

    /// All layers: the trunk's, the density's, the feature's, the colour network's.
    pub fn layers(&self) -> impl Iterator<Item = &Dense<'a>> {
        let heads = core::iter::once(&self.density).chain(&self.feature);
        self.trunk().iter().chain(heads).chain(self.color.layers())
    }

    /// Checks the layers; so many values encode a position and a direction.
    pub(super) fn validate(&self, n_position: usize, n_direction: usize) -> Result<(), Error> {
        for layer in self.layers() {
            layer.validate(self.trunk[0].weight.dtype())?;
        }
        if self.skips & 1 != 0
            || (u32::from(self.skips) | u32::from(self.linear)) >> self.depth != 0
        {
            return Err(Error::Range("network: a skip connection or a layer without ReLU"));
        }
        let mut width = 0;
        for (i, layer) in self.trunk().iter().enumerate() {
            let again = if i == 0 || self.skips(i) { n_position } else { 0 };
            if layer.weight.rows() != again + width {
                return Err(Error::Shape("network: a layer of the trunk and what it reads"));
            }
            width = layer.weight.cols();
        }
        if [self.density.weight.rows(), self.density.weight.cols()] != [width, 1] {
            return Err(Error::Shape("network: the density's layer"));
        }
        if let Some(feature) = &self.feature {
            if feature.weight.rows() != width {
                return Err(Error::Shape("network: the feature's layer"));
            }
            width = feature.weight.cols();
        }
        if self.color.n_input() != width + n_direction || self.color.n_output() != 3 {
            return Err(Error::Shape("network: the colour network"));
        }
        Ok(())
    }

    /// The widest of what goes from one layer to the next.
    pub(super) fn widest(&self) -> usize {
        let outputs = self.layers().map(|layer| layer.weight.cols());
        outputs.max().unwrap_or(0)
    }

    /// The most values that a layer reads.
    pub(super) fn most_inputs(&self) -> usize {
        self.layers().map(|layer| layer.weight.rows()).max().unwrap_or(0)
    }
}

impl NerfNetwork<'_> {
    /// From encoded points and directions to densities before their activation, a row a
    /// block, and colours before theirs, `[block][3]`, which end in one of the two
    /// buffers: each has room for the widest layer. Without directions there are no
    /// colours.
    pub(super) fn forward<'b, S: Simd>(
        &self,
        simd: S,
        (x, directions): (Blocks<'_>, Option<Blocks<'_>>),
        [a, b]: [&'b mut [Row]; 2],
        density: &mut [Row],
        panel: &mut [f32],
    ) -> &'b [Row] {
        let blocks = density.len();
        let rows = |n: usize| n * blocks;
        let (mut from, mut to) = (a, b);
        let mut width = 0;
        for (i, layer) in self.trunk().iter().enumerate() {
            let hidden = Blocks { rows: &from[..rows(width)], per_block: width };
            let sources = match (i, self.skips(i)) {
                (0, _) => [x, Blocks::NONE],
                (_, true) => [x, hidden],
                (_, false) => [hidden, Blocks::NONE],
            };
            width = layer.weight.cols();
            let y = &mut to[..rows(width)];
            dense_blocks(simd, layer, sources, y, self.relu_after(i), panel);
            core::mem::swap(&mut from, &mut to);
        }
        let hidden = Blocks { rows: &from[..rows(width)], per_block: width };
        dense_blocks(simd, &self.density, [hidden, Blocks::NONE], density, false, panel);
        let Some(directions) = directions else { return &[] };
        if let Some(feature) = &self.feature {
            width = feature.weight.cols();
            let y = &mut to[..rows(width)];
            let relu = self.feature_relu;
            dense_blocks(simd, feature, [hidden, Blocks::NONE], y, relu, panel);
            core::mem::swap(&mut from, &mut to);
        }
        let last = self.color.layers().len() - 1;
        for (i, layer) in self.color.layers().iter().enumerate() {
            let hidden = Blocks { rows: &from[..rows(width)], per_block: width };
            let second = if i == 0 { directions } else { Blocks::NONE };
            width = layer.weight.cols();
            let y = &mut to[..rows(width)];
            dense_blocks(simd, layer, [hidden, second], y, i != last, panel);
            core::mem::swap(&mut from, &mut to);
        }
        &from[..rows(width)]
    }
}
