//! What of a field the oracle has for every kind: whether it can be evaluated, where it holds
//! anything, and the networks behind an encoding. Each kind's own oracle stands beside its
//! kernels, in `field`, and knows nothing of them.

#[cfg(any(feature = "hash-grid", feature = "planes"))]
mod decoder;

#[cfg(any(feature = "hash-grid", feature = "planes"))]
pub(crate) use decoder::decode;

use crate::field::{Decoder, Features};
use crate::reference::harmonics::harmonics;
use crate::reference::math::logistic;
use crate::reference::network::{self, MAX_WIDTH};
use crate::{Error, Model};

/// Checks that the parts fit together and that the reference can evaluate them.
pub(super) fn check(model: &Model<'_>) -> Result<(), Error> {
    model.validate()?;
    match model.field.decoder() {
        Some(decoder) => {
            network::check(&decoder.density)?;
            network::check(&decoder.color)
        }
        None if model.field.limits().width > MAX_WIDTH => Err(network::TOO_WIDE),
        None => Ok(()),
    }
}

/// The unit coordinates of local point `p` where the model may hold something:
/// inside the box, its faces included, and in an occupied cell.
pub(super) fn place(model: &Model<'_>, p: [f32; 3]) -> Option<[f32; 3]> {
    let [min, max] = model.space.bounds();
    let inside = (0..3).all(|axis| min[axis] <= p[axis] && p[axis] <= max[axis]);
    let u = model.space.unit_map().apply(p);
    let occupied = match &model.occupancy {
        Some(occupancy) => occupancy.at(u),
        None => true,
    };
    (inside && occupied).then_some(u)
}

/// The colour of `features` seen along `direction`: the logistic of the colour
/// network's outputs for `[features, harmonics(direction)]`. Each is in [0, 1].
pub(super) fn shade(decoder: &Decoder<'_>, features: &Features, direction: [f32; 3]) -> [f64; 3] {
    let n = decoder.n_features as usize;
    let harmonics = harmonics(decoder.sh_degree, direction);
    let mut input = [0.0; MAX_WIDTH];
    input[..n].copy_from_slice(&features[..n]);
    input[n..n + harmonics.len()].copy_from_slice(&harmonics);
    let out = network::forward(&decoder.color, &input);
    [logistic(out[0]), logistic(out[1]), logistic(out[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use crate::field::{MAX_CHANNELS, ReferenceField, Shading};
    use crate::reference::testing::{SceneBuilder, dense, kinds};

    #[test]
    fn outputs_of_the_density_network() {
        // Encoded z = 2 u.z - 1 = 0.5 at u.z = 0.75. Output 0 is 2 z + 1 = 2, output 1
        // is 4 z + 3 = 5, output 2 is -6 z = -3 (no ReLU). The bias takes 2 to 0.
        for kind in kinds() {
            let mut scene = SceneBuilder::new(&kind, [2.0, 4.0, -6.0], [1.0, 3.0, 0.0]);
            scene.decoder.log_density_bias = -2.0;
            scene.decoder.shading = Shading::PerRay;
            let field = scene.build().field;
            let (sigma, features) = field.reference([0.1, 0.2, 0.75], [0.0, 0.0, 1.0]);
            assert!((sigma - 1.0).abs() < 1e-14);
            assert!((features[0] - 5.0).abs() < 1e-14 && (features[1] + 3.0).abs() < 1e-14);
            assert_eq!(features[2..], [0.0; MAX_CHANNELS - 2]);
        }
    }

    #[test]
    fn log_density_is_cut_off_and_nan_is_empty() {
        for kind in kinds() {
            for (raw, expected) in [
                (14.0, 14f64.exp()),
                (15.0, 15f64.exp()),
                (1000.0, 15f64.exp()),
                (f32::INFINITY, 15f64.exp()),
                (f32::NEG_INFINITY, 0.0),
                (-1000.0, 0.0),
                (f32::NAN, 0.0),
            ] {
                let scene = SceneBuilder::new(&kind, [0.0; 3], [raw, 0.0, 0.0]).build();
                let (sigma, _) = scene.field.reference([0.5; 3], [0.0, 0.0, 1.0]);
                assert!((sigma - expected).abs() <= 1e-14 * expected, "{raw}: {sigma}");
            }
        }
    }

    #[test]
    fn color_reads_features_then_harmonics() {
        for kind in kinds() {
            let mut scene = SceneBuilder::new(&kind, [0.0; 3], [0.0; 3]);
            scene.decoder.sh_degree = 2;
            // Six inputs: features 0 and 1, then harmonics 0 to 3; red reads feature 1,
            // green harmonic 2 (0.4886 z), blue a bias of -1.
            let mut weight = [0.0; 18];
            weight[3] = 1.0;
            weight[4 * 3 + 1] = 1.0;
            scene.set_color(&[dense(6, 3, &weight, &[0.0, 0.0, -1.0])]);
            let mut features = [0.0; MAX_CHANNELS];
            features[..2].copy_from_slice(&[9.0, -2.0]);
            let rgb = shade(&scene.decoder, &features, [0.6, 0.0, 0.8]);
            // 1 / (1 + e^2), 1 / (1 + e^(-0.8 * 0.48860251)), 1 / (1 + e).
            let hand = [0.119_202_922, 0.596_495_006, 0.268_941_421];
            for (found, hand) in rgb.into_iter().zip(hand) {
                assert!((found - hand).abs() < 1e-8, "{found} {hand}");
            }
        }
    }
}
