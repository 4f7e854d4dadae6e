//! Vanilla NeRFs: FIELD is encodings and networks.

mod tensors;

use pocketnerf_core::TensorView;
use pocketnerf_core::encoding::{Fourier, Waves};
use pocketnerf_core::field::{Activation, NerfField, NerfNetwork};
use serde::{Deserialize, Serialize};

use super::FieldKind;
use super::widths::Widths;
use crate::FormatError;
use crate::directory::Listed;
use crate::metadata::{Fields, append};
use crate::tensor_name::{Known, TensorName};

/// Codes of [`FourierV1`]'s waves.
const OCTAVES: u8 = 0;
const GAUSSIAN: u8 = 1;
/// Codes of [`Activation`].
const ACTIVATIONS: [Activation; 3] = [Activation::Relu, Activation::Softplus, Activation::Exp];

/// FIELD after its code.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct NerfV1 {
    positions: FourierV1,
    directions: Option<FourierV1>,
    scale: [f32; 3],
    offset: [f32; 3],
    activation: u8,
    density_scale: f32,
    fine: NetworkV1,
    coarse: Option<NetworkV1>,
}

/// An encoding in [`NerfV1`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct FourierV1 {
    waves: u8,
    /// Octaves or random frequencies.
    n: u32,
    /// Whether phases of octaves have the factor π.
    pi: bool,
    include_input: bool,
}

/// A network in [`NerfV1`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct NetworkV1 {
    trunk: Widths,
    /// Bit i: layer i of the trunk reads the encoded position once more.
    skips: u16,
    /// Bit i: no ReLU after layer i of the trunk.
    linear: u16,
    feature: FeatureV1,
    color: Widths,
}

/// The layer between trunk and colour network in [`NetworkV1`], with its width.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum FeatureV1 {
    Nothing,
    Linear(u32),
    /// ReLU follows.
    Bent(u32),
}

impl FeatureV1 {
    /// Its width, if there is one.
    const fn width(self) -> Option<u32> {
        match self {
            Self::Nothing => None,
            Self::Linear(width) | Self::Bent(width) => Some(width),
        }
    }
}

impl<'a> FieldKind<'a> for NerfField<'a> {
    const NAMES: &'static [Known] = tensors::NAMES;
    const MAX_TENSORS: usize = tensors::MAX_TENSORS;
    type Metadata = NerfV1;

    fn read(mut fields: Fields<'a>) -> Result<NerfV1, FormatError> {
        let nerf: NerfV1 = fields.take()?;
        fields.finite("scale", &nerf.scale)?;
        fields.finite("offset", &nerf.offset)?;
        fields.finite("density_scale", &[nerf.density_scale])?;
        for encoding in core::iter::once(&nerf.positions).chain(&nerf.directions) {
            if !matches!(encoding.waves, OCTAVES | GAUSSIAN) {
                return Err(fields.unknown("waves of an encoding", encoding.waves));
            }
        }
        if usize::from(nerf.activation) >= ACTIVATIONS.len() {
            return Err(fields.unknown("activation", nerf.activation));
        }
        fields.finish()?;
        Ok(nerf)
    }

    fn open(metadata: &NerfV1, listed: &mut Listed<'a>) -> Result<Self, FormatError> {
        tensors::open(metadata, listed)
    }

    fn metadata(&self) -> Option<NerfV1> {
        Some(NerfV1 {
            positions: FourierV1::of(&self.positions),
            directions: self.directions.as_ref().map(FourierV1::of),
            scale: self.map.scale,
            offset: self.map.offset,
            activation: ACTIVATIONS.iter().position(|a| *a == self.activation)? as u8,
            density_scale: self.density_scale,
            fine: NetworkV1::of(&self.fine)?,
            coarse: match &self.coarse {
                Some(network) => Some(NetworkV1::of(network)?),
                None => None,
            },
        })
    }

    fn write<W: Extend<u8>>(metadata: &NerfV1, bytes: W) -> Option<W> {
        append(bytes, metadata)
    }

    fn tensors(&self) -> impl Iterator<Item = (TensorName, TensorView<'a>)> {
        tensors::tensors(self)
    }
}

impl NerfV1 {
    fn activation(&self) -> Activation {
        ACTIVATIONS[usize::from(self.activation)]
    }
}

impl FourierV1 {
    fn of(encoding: &Fourier<'_>) -> Self {
        let include_input = encoding.include_input;
        match &encoding.waves {
            Waves::Octaves { n, pi } => Self { waves: OCTAVES, n: *n, pi: *pi, include_input },
            Waves::Gaussian(matrix) => {
                Self { waves: GAUSSIAN, n: matrix.shape()[1], pi: false, include_input }
            }
        }
    }

    /// Whether the frequencies are a tensor.
    const fn is_gaussian(&self) -> bool {
        self.waves == GAUSSIAN
    }
}

impl NetworkV1 {
    fn of(network: &NerfNetwork<'_>) -> Option<Self> {
        let trunk = network.trunk();
        Some(Self {
            trunk: Widths::of(trunk)?,
            skips: network.skips,
            linear: network.linear,
            feature: match network.feature.as_ref().map(|layer| layer.weight.shape()[1]) {
                None => FeatureV1::Nothing,
                Some(width) if network.feature_relu => FeatureV1::Bent(width),
                Some(width) => FeatureV1::Linear(width),
            },
            color: Widths::of(network.color.layers())?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::{encode, test_section};

    fn widths(values: &[u32]) -> Widths {
        let mut widths = Widths::default();
        assert!(values.iter().all(|width| widths.push(*width)));
        widths
    }

    fn read(bytes: &[u8]) -> Result<NerfV1, FormatError> {
        NerfField::read(Fields::open(&test_section(kind::FIELD, bytes))?)
    }

    /// Ten octaves, random directions, three layers of which layer 2 is a skip and
    /// layer 1 linear, and a coarse network without a feature layer.
    #[test]
    fn bytes_of_nerf_v1() {
        let network = NetworkV1 {
            trunk: widths(&[63, 24, 24, 16]),
            skips: 4,
            linear: 2,
            feature: FeatureV1::Linear(300),
            color: widths(&[340, 3]),
        };
        let nerf = NerfV1 {
            positions: FourierV1 { waves: OCTAVES, n: 10, pi: true, include_input: true },
            directions: Some(FourierV1 { waves: GAUSSIAN, n: 20, pi: false, include_input: false }),
            scale: [2.0, 1.0, 0.5],
            offset: [-1.0, 0.0, 1.0],
            activation: 1,
            density_scale: 4.0,
            fine: network,
            coarse: Some(NetworkV1 {
                feature: FeatureV1::Nothing,
                color: widths(&[56, 3]),
                ..network
            }),
        };
        #[rustfmt::skip]
        let golden = [
            0, 10, 1, 1,
            1, 1, 20, 0, 0,
            0, 0, 0, 0x40,     0, 0, 0x80, 0x3f,  0, 0, 0, 0x3f,
            0, 0, 0x80, 0xbf,  0, 0, 0, 0,        0, 0, 0x80, 0x3f,
            1,
            0, 0, 0x80, 0x40,
            4, 63, 24, 24, 16,  4, 2,  1, 0xac, 0x02,  2, 0xd4, 0x02, 3,
            1,
            4, 63, 24, 24, 16,  4, 2,  0,              2, 56, 3,
        ];
        let mut bytes = NerfField::write(&nerf, alloc::vec::Vec::new()).unwrap();
        assert_eq!(bytes, golden);
        assert_eq!(read(&bytes), Ok(nerf));
        assert_eq!(nerf.activation(), Activation::Softplus);
        let bent = encode(&FeatureV1::Bent(300));
        assert_eq!(bent, [2, 0xac, 0x02]);
        assert!(!nerf.positions.is_gaussian() && nerf.directions.unwrap().is_gaussian());
        let section = SectionId::first(kind::FIELD);
        for end in 0..bytes.len() {
            assert_eq!(read(&bytes[..end]), Err(FormatError::Metadata(section)));
        }
        for (at, field) in
            [(0, "waves of an encoding"), (5, "waves of an encoding"), (33, "activation")]
        {
            let right = core::mem::replace(&mut bytes[at], 3);
            assert_eq!(read(&bytes), Err(FormatError::UnknownCode { section, field, found: 3 }));
            bytes[at] = right;
        }
    }
}
