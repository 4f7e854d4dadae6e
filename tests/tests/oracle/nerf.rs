//! Vanilla NeRFs with random weights.

use pocketnerf_core::DType;
use pocketnerf_core::encoding::{Affine, Fourier, Waves};
use pocketnerf_core::field::Field as _;
use pocketnerf_core::field::{Activation, NerfField, NerfNetwork};
use pocketnerf_core::network::{Dense, Mlp};

use crate::models::Tensors;

/// What to build.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nerf {
    pub positions: Encoding,
    pub directions: Option<Encoding>,
    /// Outputs of the trunk's layers.
    pub trunk: &'static [usize],
    pub skips: u16,
    pub linear: u16,
    pub feature: Option<usize>,
    /// ReLU after the feature.
    pub feature_relu: bool,
    pub coarse: bool,
    pub activation: Activation,
}

/// An encoding.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Encoding {
    Octaves { n: u32, pi: bool, include_input: bool },
    Gaussian { n: usize, include_input: bool },
}

impl Nerf {
    /// As small as can be.
    const PLAIN: Self = Self {
        positions: Encoding::Octaves { n: 0, pi: false, include_input: true },
        directions: None,
        trunk: &[24],
        skips: 0,
        linear: 0,
        feature: None,
        feature_relu: false,
        coarse: false,
        activation: Activation::Relu,
    };

    /// The original's, with fewer octaves: random weights of high ones are noise.
    pub(crate) const PAPER: Self = Self {
        positions: Encoding::Octaves { n: 3, pi: false, include_input: true },
        directions: Some(Encoding::Octaves { n: 2, pi: false, include_input: true }),
        trunk: &[256; 8],
        skips: 1 << 5,
        feature: Some(256),
        ..Self::PLAIN
    };

    /// Every encoding, with and without each part, widths that fill no panel.
    pub(crate) const ALL: [Self; 7] = [
        Self::PLAIN,
        Self {
            positions: Encoding::Octaves { n: 3, pi: false, include_input: true },
            directions: Some(Encoding::Octaves { n: 2, pi: true, include_input: true }),
            trunk: &[24; 5],
            skips: 1 << 2,
            feature: Some(13),
            activation: Activation::Softplus,
            coarse: true,
            ..Self::PLAIN
        },
        Self {
            positions: Encoding::Octaves { n: 2, pi: true, include_input: false },
            trunk: &[17, 9],
            skips: 1 << 1,
            linear: 1 << 1,
            activation: Activation::Exp,
            ..Self::PLAIN
        },
        Self {
            positions: Encoding::Gaussian { n: 11, include_input: false },
            directions: Some(Encoding::Gaussian { n: 3, include_input: false }),
            trunk: &[24, 24, 40],
            activation: Activation::Softplus,
            ..Self::PLAIN
        },
        Self {
            positions: Encoding::Gaussian { n: 5, include_input: true },
            trunk: &[40],
            feature: Some(1),
            coarse: true,
            ..Self::PLAIN
        },
        Self {
            positions: Encoding::Octaves { n: 4, pi: false, include_input: true },
            directions: Some(Encoding::Octaves { n: 0, pi: false, include_input: true }),
            trunk: &[32; 10],
            skips: 0b10_0001_0010,
            linear: 1,
            coarse: true,
            feature: Some(24),
            feature_relu: true,
            activation: Activation::Exp,
        },
        Self {
            positions: Encoding::Octaves { n: 3, pi: true, include_input: true },
            directions: Some(Encoding::Octaves { n: 1, pi: false, include_input: false }),
            trunk: &[8, 31],
            activation: Activation::Relu,
            ..Self::PLAIN
        },
    ];

    pub(crate) fn build(self, tensors: &mut Tensors) -> NerfField<'static> {
        let positions = self.positions.build(tensors, 0.7);
        let directions = self.directions.map(|encoding| encoding.build(tensors, 0.4));
        let n_direction = directions.map_or(0, |encoding| encoding.n_output());
        let inputs = [positions.n_output(), n_direction];
        let field = NerfField {
            positions,
            directions,
            map: Affine { scale: [2.0, 1.5, 2.0], offset: [-1.0, -0.5, -1.0] },
            activation: self.activation,
            density_scale: if self.activation == Activation::Exp { 0.3 } else { 4.0 },
            fine: self.network(tensors, inputs),
            coarse: self.coarse.then(|| self.network(tensors, inputs)),
        };
        field.validate().expect("a field that fits together");
        field
    }

    fn network(
        self,
        tensors: &mut Tensors,
        [n_position, n_direction]: [usize; 2],
    ) -> NerfNetwork<'static> {
        let mut width = 0;
        let trunk: Vec<Dense<'static>> = (0..)
            .zip(self.trunk)
            .map(|(i, n_out)| {
                let again = i == 0 || self.skips >> i & 1 == 1;
                let n_in = width + if again { n_position } else { 0 };
                width = *n_out;
                tensors.dense(n_in, width, 1.0, i != 1)
            })
            .collect();
        let density = tensors.dense(width, 1, 4.0, true);
        let feature = self.feature.map(|n| {
            let layer = tensors.dense(width, n, 1.0, true);
            width = n;
            layer
        });
        let color =
            [tensors.dense(width + n_direction, 16, 1.0, true), tensors.dense(16, 3, 2.0, false)];
        let color = Mlp::new(&color).unwrap();
        let bits = [self.skips, self.linear];
        let mut network = NerfNetwork::new(&trunk, bits, density, feature, color).unwrap();
        network.feature_relu = self.feature_relu;
        network
    }
}

impl Encoding {
    fn build(self, tensors: &mut Tensors, spread: f32) -> Fourier<'static> {
        match self {
            Self::Octaves { n, pi, include_input } => {
                Fourier { waves: Waves::Octaves { n, pi }, include_input }
            }
            Self::Gaussian { n, include_input } => {
                // Stored as they are, as a file has them.
                let dtype = std::mem::replace(&mut tensors.dtype, DType::F32);
                let matrix = tensors.tensor(3, n, spread);
                tensors.dtype = dtype;
                Fourier { waves: Waves::Gaussian(matrix), include_input }
            }
        }
    }
}
