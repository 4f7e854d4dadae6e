//! The sum along one ray.

use super::field::{place, shade};
use super::math::exp;
use super::space::Path;
use crate::field::{Features, MAX_CHANNELS, ReferenceField};
use crate::march::MAX_STEPS;
use crate::{Model, Ray, Sampling};

/// What a ray sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayResult {
    /// Colour, premultiplied: each channel is in [0, `opacity`].
    pub rgb: [f32; 3],
    /// Part of the light behind that is held back, in [0, 1]: the sum of the
    /// weights, or 1 where the ray ended because too little light passed.
    pub opacity: f32,
    /// Expected distance of what is seen, scene units along the ray: the mean
    /// of t over the weights. Infinite where `opacity` is 0.
    pub depth: f32,
    /// Points at which the field was evaluated.
    pub samples: u32,
}

impl RayResult {
    /// A ray that meets nothing.
    pub const EMPTY: Self = Self { rgb: [0.0; 3], opacity: 0.0, depth: f32::INFINITY, samples: 0 };

    /// The colour over `background`: `rgb + (1 - opacity) * background`.
    /// Where `opacity` is 0 this is the background exactly.
    #[must_use]
    pub fn over(&self, background: [f32; 3]) -> [f32; 3] {
        let behind = 1.0 - f64::from(self.opacity);
        let mut color = self.rgb;
        for (c, b) in color.iter_mut().zip(background) {
            *c = (f64::from(*c) + behind * f64::from(b)) as f32;
        }
        color
    }
}

impl Default for RayResult {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// The running sums of NeRF's equation 3.
struct Sums {
    /// Light that comes through all samples so far: T.
    transmittance: f64,
    /// Sum of w.
    opacity: f64,
    /// Sum of w t.
    distance: f64,
    /// Sum of w times a colour or features.
    channels: Features,
}

impl Sums {
    const NEW: Self =
        Self { transmittance: 1.0, opacity: 0.0, distance: 0.0, channels: [0.0; MAX_CHANNELS] };

    /// Adds a sample of density `sigma` that stands for `step` of the ray at `t`.
    /// A sample of density 0 adds nothing, whatever its channels are.
    fn add(&mut self, sigma: f64, step: f64, t: f64, channels: &[f64]) {
        if sigma == 0.0 {
            return;
        }
        let alpha = 1.0 - exp(-sigma * step);
        let weight = self.transmittance * alpha;
        self.opacity += weight;
        self.distance += weight * t;
        for (sum, value) in self.channels.iter_mut().zip(channels) {
            *sum += weight * value;
        }
        self.transmittance *= 1.0 - alpha;
    }
}

/// Marches `ray` through a checked model.
pub(super) fn march(model: &Model<'_>, ray: &Ray) -> RayResult {
    let Sampling { step, near, far, min_transmittance } = model.sampling;
    let Some(path) = Path::new(&model.space, ray) else { return RayResult::EMPTY };
    let mut sums = Sums::NEW;
    let mut samples = 0;
    for k in 0..MAX_STEPS {
        let t = (k as f32 + 0.5) * step + near;
        if t > far {
            break;
        }
        let Some(u) = path.point(t).and_then(|p| place(model, p)) else { continue };
        samples += 1;
        let (sigma, channels) = model.field.reference(u, ray.direction);
        sums.add(sigma, f64::from(step), f64::from(t), &channels);
        if sums.transmittance < f64::from(min_transmittance) {
            break;
        }
    }
    if sums.opacity as f32 == 0.0 {
        return RayResult { samples, ..RayResult::EMPTY };
    }
    // A ray that ended early counts as opaque.
    let ended = sums.transmittance < f64::from(min_transmittance);
    let alpha = if ended { 1.0 } else { sums.opacity };
    let mean = sums.channels.map(|sum| sum / sums.opacity);
    let rgb = match model.field.deferred() {
        None => [mean[0], mean[1], mean[2]],
        Some(decoder) => shade(decoder, &mean, ray.direction),
    };
    RayResult {
        rgb: rgb.map(|c| (alpha * c) as f32),
        opacity: alpha as f32,
        depth: path.depth(&model.space, ray, sums.distance / sums.opacity) as f32,
        samples,
    }
}

/// The local point at distance `t`, in f32 as every renderer has it.
pub(super) fn point(ray: &Ray, t: f32) -> [f32; 3] {
    let (o, d) = (ray.origin, ray.direction);
    [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// exp(-LN_2 * n) = 2^-n.
    const LN_2: f64 = core::f64::consts::LN_2;

    fn close(found: f64, hand: f64) {
        assert!((found - hand).abs() <= 1e-14 * hand.abs().max(1.0), "{found}, by hand {hand}");
    }

    #[test]
    fn five_samples_by_hand() {
        // Step 1/2; sample k has sigma = 2 ln 2 * 2^k, so sigma * step = ln 2 * 2^k and
        // alpha = 1 - 2^-(2^k). T before sample k is 2^-(2^k - 1).
        //   k      alpha          T before   w                  t
        //   0      1/2            1          1/2                1
        //   1      3/4            1/2        3/8                2
        //   2      15/16          1/8        15/128             3
        //   3      255/256        1/128      255/32768          4
        //   4      65535/65536    1/32768    65535/2147483648   5
        let before = [1.0, 1.0 / 2.0, 1.0 / 8.0, 1.0 / 128.0, 1.0 / 32768.0];
        let weights =
            [1.0 / 2.0, 3.0 / 8.0, 15.0 / 128.0, 255.0 / 32768.0, 65535.0 / 2_147_483_648.0];
        let mut sums = Sums::NEW;
        for k in 0..5 {
            close(sums.transmittance, before[k]);
            let opacity = sums.opacity;
            let sigma = 2.0 * LN_2 * f64::from(1u32 << k);
            sums.add(sigma, 0.5, 1.0 + k as f64, &[1.0, k as f64]);
            close(sums.opacity - opacity, weights[k]);
        }
        close(sums.transmittance, 1.0 / 2_147_483_648.0);
        // The weights add up to 1 - 2^-31. Channel 1 holds the sum of w k:
        // 3/8 + 30/128 + 765/32768 + 4 * 65535 / 2^31.
        close(sums.opacity, 1.0 - 1.0 / 2_147_483_648.0);
        close(sums.channels[0], sums.opacity);
        let mean_k = 0.375 + 0.234_375 + 765.0 / 32768.0 + 262_140.0 / 2_147_483_648.0;
        close(sums.channels[1], mean_k);
        close(sums.distance, sums.opacity + mean_k);
    }

    #[test]
    fn a_sample_of_density_0_adds_nothing() {
        let mut sums = Sums::NEW;
        sums.add(0.0, 0.5, 1.0, &[f64::NAN]);
        assert_eq!((sums.transmittance, sums.opacity, sums.channels[0]), (1.0, 0.0, 0.0));
    }

    #[test]
    fn over_a_background_by_hand() {
        let half = RayResult { rgb: [0.5, 0.25, 0.0], opacity: 0.5, depth: 1.0, samples: 3 };
        assert_eq!(half.over([1.0, 0.5, 0.25]), [1.0, 0.5, 0.125]);
        let background = [0.1, 0.7, 1.0 / 3.0];
        assert_eq!(RayResult::EMPTY.over(background), background);
    }
}
