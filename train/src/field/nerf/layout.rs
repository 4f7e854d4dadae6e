//! The tensors of a vanilla NeRF, where they lie, and the field that reads them.

use pocketnerf_core::encoding::Affine;
use pocketnerf_core::field::{NerfField, NerfNetwork};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{Error, TensorView};

use super::{FourierConfig, NerfConfig, WavesConfig};
use crate::field::layout::{Layout, Part, Range, Role};

/// A layer of one of the field's networks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NerfLayer {
    /// Of the trunk, counted from 0.
    Trunk(usize),
    /// The density.
    Density,
    /// The feature.
    Feature,
    /// Of the colour network, counted from 0.
    Color(usize),
}

impl NerfLayer {
    /// Its weights or biases in the coarse or the fine network.
    #[must_use]
    pub const fn part(self, coarse: bool, role: Role) -> Part {
        let (network, layer) = match (self, coarse) {
            (Self::Trunk(i), false) => ("fine trunk", i),
            (Self::Trunk(i), true) => ("coarse trunk", i),
            (Self::Density, false) => ("fine density", 0),
            (Self::Density, true) => ("coarse density", 0),
            (Self::Feature, false) => ("fine feature", 0),
            (Self::Feature, true) => ("coarse feature", 0),
            (Self::Color(i), false) => ("fine color", i),
            (Self::Color(i), true) => ("coarse color", i),
        };
        Part { network, layer, role }
    }
}

/// `[3, n]` random frequencies of positions or of directions, which are not trained.
const FREQUENCIES: [Part; 2] = [
    Part { network: "frequencies of positions", layer: 0, role: Role::Fixed },
    Part { network: "frequencies of directions", layer: 0, role: Role::Fixed },
];

impl NerfConfig {
    /// Where each tensor lies: random frequencies, the fine network, the coarse one.
    #[must_use]
    pub fn layout(&self) -> Layout {
        let mut layout = Layout::default();
        for (part, n, _) in self.frequencies() {
            layout.push(part, [3, n]);
        }
        for coarse in [false, true].into_iter().take(1 + usize::from(self.coarse)) {
            for layer in self.layers() {
                let shape = self.shape(layer);
                layout.push(layer.part(coarse, Role::Weight), shape);
                layout.push(layer.part(coarse, Role::Bias), [1, shape[1]]);
            }
        }
        layout
    }

    /// The random frequencies, their number and standard deviation.
    pub(super) fn frequencies(&self) -> impl Iterator<Item = (Part, usize, f32)> {
        let waves = [Some(self.positions.waves), self.directions.map(|d| d.waves)];
        waves.into_iter().zip(FREQUENCIES).filter_map(|(waves, part)| match waves {
            Some(WavesConfig::Gaussian { n, deviation }) => Some((part, n as usize, deviation)),
            _ => None,
        })
    }

    /// The field of the tensors of a layout, whose densities are per `1 / scale` scene
    /// units.
    ///
    /// # Errors
    /// Whatever core's validation reports.
    pub fn view<'a>(
        &self,
        layout: &Layout,
        scale: f32,
        tensor: impl Fn(&Range) -> Result<TensorView<'a>, Error>,
    ) -> Result<NerfField<'a>, Error> {
        let tensor = |part| tensor(&layout.range(part));
        let encoding = |config: FourierConfig, frequencies| {
            let matrix = match config.waves {
                WavesConfig::Gaussian { .. } => Some(tensor(frequencies)?),
                WavesConfig::Octaves { .. } => None,
            };
            Ok(config.view(matrix))
        };
        let network = |coarse| {
            let dense = |layer: NerfLayer| {
                let part = |role| tensor(layer.part(coarse, role));
                Ok::<_, Error>(Dense { weight: part(Role::Weight)?, bias: Some(part(Role::Bias)?) })
            };
            let trunk: Result<Vec<_>, _> =
                (0..self.depth).map(|i| dense(NerfLayer::Trunk(i))).collect();
            let skips = if self.skip == 0 { 0 } else { 1 << self.skip };
            let feature = self.has_feature().then(|| dense(NerfLayer::Feature)).transpose()?;
            let color = Mlp::new(&[dense(NerfLayer::Color(0))?, dense(NerfLayer::Color(1))?])?;
            NerfNetwork::new(&trunk?, [skips, 0], dense(NerfLayer::Density)?, feature, color)
        };
        let [positions, directions] = FREQUENCIES;
        Ok(NerfField {
            positions: encoding(self.positions, positions)?,
            directions: self.directions.map(|config| encoding(config, directions)).transpose()?,
            map: Affine::CENTRED,
            activation: self.activation,
            density_scale: scale,
            fine: network(false)?,
            coarse: self.coarse.then(|| network(true)).transpose()?,
        })
    }
}
