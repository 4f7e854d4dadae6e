//! FIELD of the paper's networks.

use pocketnerf_core::field::Activation;
use serde::{Deserialize, Serialize};

use super::Fields;
use super::widths::Widths;
use crate::FormatError;

/// Codes of [`FourierV1`]'s waves.
const OCTAVES: u8 = 0;
const GAUSSIAN: u8 = 1;
/// Codes of [`Activation`].
const ACTIVATIONS: [Activation; 3] = [Activation::Relu, Activation::Softplus, Activation::Exp];

/// FIELD after its code, the paper's networks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct NerfV1 {
    pub(crate) positions: FourierV1,
    pub(crate) directions: Option<FourierV1>,
    pub(crate) scale: [f32; 3],
    pub(crate) offset: [f32; 3],
    activation: u8,
    pub(crate) density_scale: f32,
    pub(crate) fine: NetworkV1,
    pub(crate) coarse: Option<NetworkV1>,
}

/// An encoding in [`NerfV1`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FourierV1 {
    waves: u8,
    /// Octaves or random frequencies.
    pub(crate) n: u32,
    /// Whether phases of octaves have the factor π.
    pub(crate) pi: bool,
    pub(crate) include_input: bool,
}

/// A network in [`NerfV1`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct NetworkV1 {
    pub(crate) trunk: Widths,
    /// Bit i: layer i of the trunk reads the encoded position once more.
    pub(crate) skips: u16,
    /// Bit i: no ReLU after layer i of the trunk.
    pub(crate) linear: u16,
    pub(crate) feature: FeatureV1,
    pub(crate) color: Widths,
}

/// What stands between trunk and colour network in [`NetworkV1`]: how wide it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum FeatureV1 {
    Nothing,
    Linear(u32),
    /// ReLU follows.
    Bent(u32),
}

impl FeatureV1 {
    /// Its width, where there is one.
    pub(crate) const fn width(self) -> Option<u32> {
        match self {
            Self::Nothing => None,
            Self::Linear(width) | Self::Bent(width) => Some(width),
        }
    }
}

impl NerfV1 {
    /// Reads what follows the code.
    pub(crate) fn read(mut fields: Fields<'_>) -> Result<Self, FormatError> {
        let nerf: Self = fields.take()?;
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

    pub(crate) fn activation(&self) -> Activation {
        ACTIVATIONS[usize::from(self.activation)]
    }
}

impl FourierV1 {
    /// Whether the frequencies are a tensor.
    pub(crate) const fn is_gaussian(&self) -> bool {
        self.waves == GAUSSIAN
    }
}

#[cfg(feature = "alloc")]
mod writing {
    use pocketnerf_core::encoding::{Fourier, Waves};
    use pocketnerf_core::field::{NerfField, NerfNetwork};

    use super::*;

    impl NerfV1 {
        /// What FIELD says of a field; `None` for a choice that the format has no code for.
        pub(crate) fn of(field: &NerfField<'_>) -> Option<Self> {
            Some(Self {
                positions: FourierV1::of(&field.positions),
                directions: field.directions.as_ref().map(FourierV1::of),
                scale: field.map.scale,
                offset: field.map.offset,
                activation: ACTIVATIONS.iter().position(|a| *a == field.activation)? as u8,
                density_scale: field.density_scale,
                fine: NetworkV1::of(&field.fine)?,
                coarse: match &field.coarse {
                    Some(network) => Some(NetworkV1::of(network)?),
                    None => None,
                },
            })
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
}

#[cfg(all(test, feature = "alloc"))]
mod tests {
    use super::*;
    use crate::metadata::test_section;
    use crate::section::{SectionId, kind};

    fn widths(values: &[u32]) -> Widths {
        let mut widths = Widths::default();
        assert!(values.iter().all(|width| widths.push(*width)));
        widths
    }

    fn read(bytes: &[u8]) -> Result<NerfV1, FormatError> {
        NerfV1::read(Fields::open(&test_section(kind::FIELD, bytes))?)
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
        let mut bytes = crate::metadata::encode(&nerf);
        assert_eq!(bytes, golden);
        assert_eq!(read(&bytes), Ok(nerf));
        assert_eq!(nerf.activation(), Activation::Softplus);
        let bent = crate::metadata::encode(&FeatureV1::Bent(300));
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
