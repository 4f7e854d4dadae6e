//! The shape of a vanilla NeRF, and how it is trained.

use pocketnerf_core::TensorView;
use pocketnerf_core::encoding::{Affine, Fourier, Waves};
use pocketnerf_core::field::{Activation, NerfField, NerfNetwork};

use super::NerfLayer;
use crate::field::HierarchicalTraining;

/// The waves of an encoding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WavesConfig {
    /// So many octaves, with or without π, see [`Waves::Octaves`].
    Octaves {
        /// Octaves; 0 is no encoding.
        n: u32,
        /// Whether phases have the factor π.
        pi: bool,
    },
    /// So many random frequencies, see [`Waves::Gaussian`].
    Gaussian {
        /// Frequencies.
        n: u32,
        /// Their standard deviation, waves a unit.
        deviation: f32,
    },
}

/// An encoding by Fourier features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourierConfig {
    /// The waves.
    pub waves: WavesConfig,
    /// Whether the coordinates themselves stand before them.
    pub include_input: bool,
}

impl FourierConfig {
    /// Values that the encoding gives.
    #[must_use]
    pub const fn n_output(&self) -> usize {
        let waves = match self.waves {
            WavesConfig::Octaves { n, .. } => 6 * n,
            WavesConfig::Gaussian { n, .. } => 2 * n,
        };
        (waves + if self.include_input { 3 } else { 0 }) as usize
    }

    pub(super) fn view(self, matrix: Option<TensorView<'_>>) -> Fourier<'_> {
        let waves = match (self.waves, matrix) {
            (WavesConfig::Gaussian { .. }, Some(matrix)) => Waves::Gaussian(matrix),
            (WavesConfig::Octaves { n, pi }, _) => Waves::Octaves { n, pi },
            (WavesConfig::Gaussian { .. }, None) => Waves::Gaussian(TensorView::EMPTY),
        };
        Fourier { waves, include_input: self.include_input }
    }
}

/// A vanilla NeRF (Mildenhall et al. 2020).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NerfConfig {
    /// Encoding of positions, in -1 .. 1.
    pub positions: FourierConfig,
    /// Encoding of directions; `None`: colours do not depend on them.
    pub directions: Option<FourierConfig>,
    /// Layers of the trunk.
    pub depth: usize,
    /// Their width.
    pub width: usize,
    /// The layer of the trunk, counted from 0, that reads the encoded point once more;
    /// 0: none.
    pub skip: usize,
    /// Width of the hidden layer that makes colours.
    pub color_width: usize,
    /// Whether there is a coarse network beside the fine one.
    pub coarse: bool,
    /// From the network's output to a density.
    pub activation: Activation,
    /// Whether it learns by Muon at first, else by Adam throughout.
    pub muon: bool,
    /// Hierarchical sampling in place of marching through occupied cells.
    pub hierarchical: Option<HierarchicalTraining>,
}

impl NerfConfig {
    /// The original: 10 and 4 octaves, eight layers of 256, of which the sixth reads the
    /// point again, 128 for the colour.
    #[must_use]
    pub fn vanilla() -> Self {
        let octaves =
            |n| FourierConfig { waves: WavesConfig::Octaves { n, pi: false }, include_input: true };
        Self {
            positions: octaves(10),
            directions: Some(octaves(4)),
            depth: 8,
            width: 256,
            skip: 5,
            color_width: 128,
            coarse: true,
            activation: Activation::Relu,
            muon: false,
            hierarchical: None,
        }
    }

    /// One network, trained in occupied cells alone: what a CPU can do in minutes.
    #[must_use]
    pub fn in_cells() -> Self {
        Self { coarse: false, activation: Activation::Exp, muon: true, ..Self::vanilla() }
    }

    /// The original, trained by hierarchical sampling.
    #[must_use]
    pub fn hierarchical(training: HierarchicalTraining) -> Self {
        Self { hierarchical: Some(training), ..Self::vanilla() }
    }

    /// The shape of a field, whose random frequencies have these deviations; `None` for
    /// one that could not be trained.
    #[must_use]
    pub fn of(field: &NerfField<'_>, deviations: [f32; 2]) -> Option<Self> {
        let encoding = |fourier: &Fourier<'_>, deviation| FourierConfig {
            waves: match fourier.waves {
                Waves::Octaves { n, pi } => WavesConfig::Octaves { n, pi },
                Waves::Gaussian(matrix) => {
                    WavesConfig::Gaussian { n: matrix.cols() as u32, deviation }
                }
            },
            include_input: fourier.include_input,
        };
        let NerfNetwork { skips, density, color, .. } = &field.fine;
        let config = Self {
            positions: encoding(&field.positions, deviations[0]),
            directions: field.directions.as_ref().map(|d| encoding(d, deviations[1])),
            depth: field.fine.trunk().len(),
            width: density.weight.rows(),
            skip: if *skips == 0 { 0 } else { skips.trailing_zeros() as usize },
            color_width: color.layers()[0].weight.cols(),
            coarse: field.coarse.is_some(),
            activation: field.activation,
            muon: false,
            hierarchical: None,
        };
        let usual = |network: &NerfNetwork<'_>| {
            network.linear == 0
                && network.skips.count_ones() <= 1
                && network.feature.is_some() == config.has_feature()
                && !network.feature_relu
                && network.color.layers().len() == 2
        };
        let nets = std::iter::once(&field.fine).chain(&field.coarse);
        (nets.into_iter().all(usual) && field.map == Affine::CENTRED).then_some(config)
    }

    /// Values that encode a direction.
    #[must_use]
    pub fn n_direction(&self) -> usize {
        self.directions.map_or(0, |directions| directions.n_output())
    }

    /// Whether a feature stands between trunk and colour.
    pub(super) const fn has_feature(&self) -> bool {
        self.directions.is_some()
    }

    /// Inputs and outputs of a layer.
    #[must_use]
    pub fn shape(&self, layer: NerfLayer) -> [usize; 2] {
        let (width, n_position) = (self.width, self.positions.n_output());
        match layer {
            NerfLayer::Trunk(0) => [n_position, width],
            NerfLayer::Trunk(i) if i == self.skip => [n_position + width, width],
            NerfLayer::Trunk(_) | NerfLayer::Feature => [width, width],
            NerfLayer::Density => [width, 1],
            NerfLayer::Color(0) => [width + self.n_direction(), self.color_width],
            NerfLayer::Color(_) => [self.color_width, 3],
        }
    }

    /// The layers of a network, in order.
    pub fn layers(&self) -> impl Iterator<Item = NerfLayer> + use<> {
        let feature = self.has_feature().then_some(NerfLayer::Feature);
        let trunk = (0..self.depth).map(NerfLayer::Trunk).chain([NerfLayer::Density]);
        trunk.chain(feature).chain([NerfLayer::Color(0), NerfLayer::Color(1)])
    }

    /// Multiply-adds of one evaluation of a network.
    #[must_use]
    pub fn multiply_adds(&self) -> usize {
        self.layers().map(|layer| self.shape(layer)).map(|[n_in, n_out]| n_in * n_out).sum()
    }
}
