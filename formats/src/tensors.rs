//! The names of the weights.

use core::fmt;

use pocketnerf_core::{AnyField, TensorView};

#[cfg(feature = "hash-grid")]
use crate::decoded;
#[cfg(feature = "nerf")]
use crate::nerf;

/// One of the two networks of the paper's field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Network {
    /// That pictures are made with.
    Fine,
    /// That says where samples are worth while.
    Coarse,
}

/// A layer of one of the paper's networks; the layers of trunk and colour network count
/// from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerName {
    /// Of the trunk.
    Trunk(u8),
    /// Trunk to density.
    Density,
    /// Trunk to feature.
    Feature,
    /// Of the colour network.
    Color(u8),
}

/// Which of a field's weights a tensor is. Levels and layers count from 0.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TensorName {
    /// The table of a hash grid level.
    GridLevel(u32),
    /// The weight of a layer of the density network.
    DensityWeight(u32),
    /// The bias of a layer of the density network.
    DensityBias(u32),
    /// The weight of a layer of the colour network.
    ColorWeight(u32),
    /// The bias of a layer of the colour network.
    ColorBias(u32),
    /// Random frequencies of positions.
    PositionFrequencies,
    /// Random frequencies of directions.
    DirectionFrequencies,
    /// The weight of a layer of one of the paper's networks.
    LayerWeight(Network, LayerName),
    /// The bias of a layer of one of the paper's networks.
    LayerBias(Network, LayerName),
}

impl fmt::Display for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fine => "fine",
            Self::Coarse => "coarse",
        })
    }
}

impl LayerName {
    /// The layer's name and its number.
    const fn parts(self) -> (&'static str, u8) {
        match self {
            Self::Trunk(i) => ("trunk", i),
            Self::Density => ("density", 0),
            Self::Feature => ("feature", 0),
            Self::Color(i) => ("colour", i),
        }
    }
}

impl fmt::Display for TensorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GridLevel(i) => write!(f, "grid level {i}"),
            Self::DensityWeight(i) => write!(f, "density weight {i}"),
            Self::DensityBias(i) => write!(f, "density bias {i}"),
            Self::ColorWeight(i) => write!(f, "colour weight {i}"),
            Self::ColorBias(i) => write!(f, "colour bias {i}"),
            Self::PositionFrequencies => f.write_str("position frequencies"),
            Self::DirectionFrequencies => f.write_str("direction frequencies"),
            Self::LayerWeight(network, layer) | Self::LayerBias(network, layer) => {
                let (name, number) = layer.parts();
                let what = if matches!(self, Self::LayerWeight(..)) { "weight" } else { "bias" };
                write!(f, "{network} {name} {what} {number}")
            }
        }
    }
}

impl TensorName {
    /// Code and index in the file.
    #[cfg(feature = "alloc")]
    pub(crate) const fn code(self) -> (u8, u32) {
        match self {
            Self::GridLevel(i) => (0, i),
            Self::DensityWeight(i) => (1, i),
            Self::DensityBias(i) => (2, i),
            Self::ColorWeight(i) => (3, i),
            Self::ColorBias(i) => (4, i),
            Self::PositionFrequencies => (5, 0),
            Self::DirectionFrequencies => (6, 0),
            Self::LayerWeight(network, layer) => layer_code(network, layer, 0),
            Self::LayerBias(network, layer) => layer_code(network, layer, 1),
        }
    }

    pub(crate) const fn from_code(code: u8, index: u32) -> Option<Self> {
        Some(match code {
            0 => Self::GridLevel(index),
            1 => Self::DensityWeight(index),
            2 => Self::DensityBias(index),
            3 => Self::ColorWeight(index),
            4 => Self::ColorBias(index),
            #[cfg(feature = "nerf")]
            5 if index == 0 => Self::PositionFrequencies,
            #[cfg(feature = "nerf")]
            6 if index == 0 => Self::DirectionFrequencies,
            #[cfg(feature = "nerf")]
            7..23 if index < 256 => {
                let layer = match (code - LAYERS) % 8 / 2 {
                    0 => LayerName::Trunk(index as u8),
                    1 if index == 0 => LayerName::Density,
                    2 if index == 0 => LayerName::Feature,
                    3 => LayerName::Color(index as u8),
                    _ => return None,
                };
                let network = if code < LAYERS + 8 { Network::Fine } else { Network::Coarse };
                match (code - LAYERS) % 2 {
                    0 => Self::LayerWeight(network, layer),
                    _ => Self::LayerBias(network, layer),
                }
            }
            _ => return None,
        })
    }
}

/// The first code of layers: for either network weight and bias of each kind of layer.
#[cfg(any(feature = "alloc", feature = "nerf"))]
const LAYERS: u8 = 7;

#[cfg(feature = "alloc")]
const fn layer_code(network: Network, layer: LayerName, bias: u8) -> (u8, u32) {
    let network = match network {
        Network::Fine => 0,
        Network::Coarse => 1,
    };
    let kind = match layer {
        LayerName::Trunk(_) => 0,
        LayerName::Density => 1,
        LayerName::Feature => 2,
        LayerName::Color(_) => 3,
    };
    (LAYERS + 8 * network + 2 * kind + bias, layer.parts().1 as u32)
}

/// The weights of a field with their names, in the order of the file.
pub fn tensors<'f, 'a>(
    field: &'f AnyField<'a>,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    let tensors = core::iter::empty();
    #[cfg(feature = "hash-grid")]
    let tensors = tensors.chain(decoded::tensors(field));
    #[cfg(feature = "nerf")]
    let tensors = tensors.chain(nerf::tensors(field));
    tensors
}

#[cfg(all(test, feature = "alloc"))]
mod tests {
    use super::*;

    #[test]
    fn names_have_codes_of_their_own() {
        for (code, index) in (0..=255).flat_map(|code| [(code, 0), (code, 9)]) {
            let last = if cfg!(feature = "nerf") { 22 } else { 4 };
            if let Some(name) = TensorName::from_code(code, index) {
                assert_eq!(name.code(), (code, index));
            } else {
                // Frequencies, density and feature are not numbered.
                let single = matches!(code, 5 | 6 | 9..=12 | 17..=20) && index > 0;
                assert!(code > last || single, "{code}");
            }
        }
        assert_eq!(TensorName::LayerBias(Network::Coarse, LayerName::Color(1)).code(), (22, 1));
    }

    #[test]
    fn names_say_which_layer() {
        use alloc::string::ToString;
        let name = TensorName::LayerWeight(Network::Coarse, LayerName::Trunk(3));
        assert_eq!(name.to_string(), "coarse trunk weight 3");
        let name = TensorName::LayerBias(Network::Fine, LayerName::Density);
        assert_eq!(name.to_string(), "fine density bias 0");
    }
}
