//! What a field says of one point: density, features and colour.

use super::harmonics::harmonics;
#[cfg(feature = "hash-grid")]
use super::math::exp;
use super::math::logistic;
#[cfg(feature = "hash-grid")]
use super::network::Values;
use super::network::{self, MAX_WIDTH};
use crate::field::{AnyField, Decoder, MAX_CHANNELS, Shading};
use crate::{Error, Model};

/// Highest log density; beyond it sigma stays at e^15 per scene unit.
#[cfg(feature = "hash-grid")]
const MAX_LOG_DENSITY: f64 = 15.0;

/// Features of a point or of a ray; those that the field does not have are 0.
pub(super) type Features = [f64; MAX_CHANNELS];

/// Checks that the parts fit together and that the reference can evaluate them.
pub(super) fn check(model: &Model<'_>) -> Result<(), Error> {
    model.validate()?;
    match decoder(&model.field) {
        Some(decoder) => {
            network::check(&decoder.density)?;
            network::check(&decoder.color)
        }
        None if model.field.limits().width > MAX_WIDTH => Err(network::TOO_WIDE),
        None => Ok(()),
    }
}

/// The networks of a field of a kind that has a decoder.
pub(super) fn decoder<'f, 'a>(field: &'f AnyField<'a>) -> Option<&'f Decoder<'a>> {
    match field {
        #[cfg(feature = "hash-grid")]
        AnyField::HashGrid(field) => Some(&field.decoder),
        #[cfg(feature = "nerf")]
        AnyField::Nerf(_) => None,
    }
}

/// The networks that make colours of what a ray has gathered, where there are any.
pub(super) fn deferred<'f, 'a>(field: &'f AnyField<'a>) -> Option<&'f Decoder<'a>> {
    decoder(field).filter(|decoder| decoder.shading == Shading::PerRay)
}

/// Sigma, per scene unit, at unit point `u`, and what a ray along `direction`
/// accumulates: a colour or features.
pub(super) fn ask(field: &AnyField<'_>, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
    match field {
        #[cfg(feature = "nerf")]
        AnyField::Nerf(field) => super::nerf::ask(field, u, direction),
        #[cfg(feature = "hash-grid")]
        _ => ask_decoded(field, u, direction),
    }
}

#[cfg(feature = "hash-grid")]
fn ask_decoded(field: &AnyField<'_>, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
    let Some(decoder) = decoder(field) else { return (0.0, [0.0; MAX_CHANNELS]) };
    let (sigma, features) = density(field, decoder, u);
    if decoder.shading == Shading::PerRay {
        return (sigma, features);
    }
    let mut channels = [0.0; MAX_CHANNELS];
    channels[..3].copy_from_slice(&shade(decoder, &features, direction));
    (sigma, channels)
}

#[cfg(feature = "hash-grid")]
fn encode(field: &AnyField<'_>, u: [f32; 3]) -> Values {
    match field {
        #[cfg(feature = "hash-grid")]
        AnyField::HashGrid(field) => super::hash_grid::encode(&field.grid, u),
        #[cfg(feature = "nerf")]
        AnyField::Nerf(_) => [0.0; MAX_WIDTH],
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

/// Sigma, per scene unit, and the features at unit point `u`.
///
/// `sigma = exp(min(raw + log_density_bias, 15))`; a NaN is empty space.
#[cfg(feature = "hash-grid")]
fn density(field: &AnyField<'_>, decoder: &Decoder<'_>, u: [f32; 3]) -> (f64, Features) {
    let out = network::forward(&decoder.density, &encode(field, u));
    let log_density = out[0] + f64::from(decoder.log_density_bias);
    let sigma = if log_density.is_nan() { 0.0 } else { exp(log_density.min(MAX_LOG_DENSITY)) };
    let mut features = [0.0; MAX_CHANNELS];
    let n = decoder.n_features as usize;
    features[..n].copy_from_slice(&out[1..=n]);
    (sigma, features)
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
    use crate::reference::testing::{SceneBuilder, dense, kinds};

    #[test]
    fn outputs_of_the_density_network() {
        // Encoded z = 2 u.z - 1 = 0.5 at u.z = 0.75. Output 0 is 2 z + 1 = 2, output 1
        // is 4 z + 3 = 5, output 2 is -6 z = -3 (no ReLU). The bias takes 2 to 0.
        for kind in kinds() {
            let mut scene = SceneBuilder::new(&kind, [2.0, 4.0, -6.0], [1.0, 3.0, 0.0]);
            scene.decoder.log_density_bias = -2.0;
            let field = scene.build().field;
            let (sigma, features) = density(&field, decoder(&field).unwrap(), [0.1, 0.2, 0.75]);
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
                let (sigma, _) = density(&scene.field, decoder(&scene.field).unwrap(), [0.5; 3]);
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
