//! Vanilla NeRF, one point and one value at a time.

use crate::encoding::{Affine, Fourier, Waves};
use crate::field::{Activation, Features, MAX_CHANNELS, NerfField, ReferenceField};
use crate::reference::math::{exp, logistic, sin_cos_pi};
use crate::reference::network::{MAX_WIDTH, Values, one};

impl ReferenceField for NerfField<'_> {
    /// NaN is empty space, and black.
    fn reference(&self, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
        evaluate(self, u, direction)
    }
}

fn evaluate(field: &NerfField<'_>, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
    let network = &field.fine;
    let encoded = encode(&field.positions, field.map, u);
    let n_position = field.positions.n_output();
    let (mut x, mut width) = ([0.0; MAX_WIDTH], 0);
    for (i, layer) in network.trunk().iter().enumerate() {
        let input = match (i, network.skips(i)) {
            (0, _) => encoded,
            (_, true) => joined((&encoded, n_position), (&x, width)),
            (_, false) => x,
        };
        x = one(layer, &input, network.relu_after(i));
        width = layer.weight.cols();
    }
    let raw = one(&network.density, &x, false)[0];
    if let Some(feature) = &network.feature {
        x = one(feature, &x, network.feature_relu);
        width = feature.weight.cols();
    }
    if let Some(directions) = &field.directions {
        let encoded = encode(directions, Affine::IDENTITY, direction);
        x = joined((&x, width), (&encoded, directions.n_output()));
    }
    let (last, hidden) = network.color.layers().split_last().expect("a network has layers");
    for layer in hidden {
        x = one(layer, &x, true);
    }
    let rgb = one(last, &x, false);
    let mut channels = [0.0; MAX_CHANNELS];
    for (to, raw) in channels.iter_mut().zip(&rgb[..3]) {
        *to = logistic(*raw);
    }
    (sigma(field.activation, raw) * f64::from(field.density_scale), channels)
}

fn sigma(activation: Activation, raw: f64) -> f64 {
    let most = exp(15.0);
    match activation {
        _ if raw.is_nan() => 0.0,
        Activation::Relu => raw.clamp(0.0, most),
        // ln(1 + e^x): the logarithm by Newton's method on e^y = 1 + e^x, from above.
        Activation::Softplus if raw > 40.0 => raw.min(most),
        Activation::Softplus => {
            let sum = 1.0 + exp(raw);
            let mut y = raw.max(0.0) + 0.7;
            for _ in 0..60 {
                y -= 1.0 - sum * exp(-y);
            }
            if raw < -30.0 { exp(raw) } else { y }
        }
        Activation::Exp => exp(raw.min(15.0)),
    }
}

/// Values one after another.
fn joined((a, n): (&Values, usize), (b, m): (&Values, usize)) -> Values {
    let mut all = [0.0; MAX_WIDTH];
    all[..n].copy_from_slice(&a[..n]);
    all[n..n + m].copy_from_slice(&b[..m]);
    all
}

/// Encodes the point that `map` makes of `u`, in f32 as every renderer has it.
fn encode(encoding: &Fourier<'_>, map: Affine, u: [f32; 3]) -> Values {
    let x = [0, 1, 2].map(|a| f64::from(u[a] * map.scale[a] + map.offset[a]));
    let mut out = [0.0; MAX_WIDTH];
    let mut at = 0;
    if encoding.include_input {
        out[..3].copy_from_slice(&x);
        at = 3;
    }
    match &encoding.waves {
        Waves::Octaves { n, pi } => {
            for k in 0..*n {
                for x in x {
                    let half_turns = if *pi { x } else { x / core::f64::consts::PI };
                    let (sin, cos) = sin_cos_pi(f64::from(1u32 << k) * half_turns);
                    (out[at], out[at + 3]) = (sin, cos);
                    at += 1;
                }
                at += 3;
            }
        }
        Waves::Gaussian(matrix) => {
            let n = matrix.cols();
            for f in 0..n {
                let turns: f64 = (0..3).map(|a| x[a] * f64::from(matrix.get(a * n + f))).sum();
                let (sin, cos) = sin_cos_pi(2.0 * turns);
                (out[at + f], out[at + n + f]) = (cos, sin);
            }
        }
    }
    out
}
