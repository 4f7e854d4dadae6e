//! Hierarchical sampling along one ray (Mildenhall et al. 2020, section 5.2), as its
//! authors' program has it when it makes a picture.
//!
//! ```text
//! t_i = near (1 − i / (n − 1)) + far i / (n − 1)        n_coarse of them, f32
//! δ_i = t_(i+1) − t_i, the last 1e10, clipped 0          f32
//! near and far divided by the cosine between ray and axis where they are depths; 0 and
//! the length of the way in normalised device coordinates, unless clipped
//! w_i = T_i (1 − exp(−σ_i δ_i)),   T_0 = 1,   T_(i+1) = T_i exp(−σ_i δ_i)
//! ```
//!
//! The inverse of the cumulative distribution of `w_i + 1e-5`, the first and the last
//! left out, each spread over what is nearer to `t_i` than to its neighbours, gives
//! `n_fine` distances more. The fine field is evaluated at all of them, and the picture is
//! Σ w c.

use super::field::{place, shade};
use super::math::exp;
use super::ray::RayResult;
use super::space::Path;
use crate::field::{AnyField, Features, MAX_CHANNELS, ReferenceField};
use crate::march::{Hierarchical, MAX_SAMPLES, Reach};
use crate::{Model, Ray};

/// Samples of a ray at most.
const MOST: usize = 2 * MAX_SAMPLES as usize;

/// Follows `ray` through a checked model.
pub(super) fn march(
    model: &Model<'_>,
    ray: &Ray,
    axis: Option<[f32; 3]>,
    hierarchical: &Hierarchical,
) -> RayResult {
    let Hierarchical { n_coarse, n_fine, reach } = *hierarchical;
    let clipped = reach == Reach::Clipped;
    let (mut near, mut far) = (model.sampling.near, model.sampling.far);
    let Some(path) = Path::new(&model.space, ray) else { return RayResult::EMPTY };
    // What the last sample stands for: all behind it, or nothing where the ray leaves the
    // space there.
    let last = if clipped { 0.0 } else { 1e10 };
    if clipped {
        let reach = path.clipped(&model.space, [near, far]);
        let Some(reach) = reach else { return RayResult::EMPTY };
        [near, far] = reach;
    } else if let Some(way) = path.whole_way(&model.space) {
        (near, far) = (0.0, way);
    } else if let (Reach::Depth, Some(axis)) = (reach, axis) {
        let cosine: f32 = (0..3).map(|a| axis[a] * ray.direction[a]).sum();
        if cosine > 1e-3 {
            (near, far) = (near * (1.0 / cosine), far * (1.0 / cosine));
        }
    }
    let (mut t, mut n) = ([0.0; MOST], n_coarse as usize);
    for (i, t) in t[..n].iter_mut().enumerate() {
        let along = i as f32 / (n - 1) as f32;
        *t = near * (1.0 - along) + far * along;
    }
    let mut samples = 0;
    if n_fine > 0 {
        let coarse = model.field.coarse();
        let coarse = coarse.as_ref().unwrap_or(&model.field);
        let mut weights = [0.0; MOST];
        let mut transmittance = 1.0;
        for i in 0..n {
            let Some((sigma, _)) = sample(model, coarse, (ray, &path), t[i], clipped) else {
                continue;
            };
            samples += 1;
            let passes = exp(-sigma * f64::from(delta(&t[..n], i, last)));
            weights[i] = transmittance * (1.0 - passes);
            transmittance *= passes;
        }
        for j in 0..n_fine {
            let at = f64::from(j) / f64::from(n_fine.max(2) - 1);
            t[n + j as usize] = inverse(&t[..n], &weights[..n], at) as f32;
        }
        n += n_fine as usize;
        t[..n].sort_unstable_by(f32::total_cmp);
    }
    let (mut transmittance, mut opacity, mut distance) = (1.0, 0.0, 0.0);
    let mut sums: Features = [0.0; MAX_CHANNELS];
    for i in 0..n {
        let Some((sigma, channels)) = sample(model, &model.field, (ray, &path), t[i], clipped)
        else {
            continue;
        };
        samples += 1;
        let passes = exp(-sigma * f64::from(delta(&t[..n], i, last)));
        let weight = transmittance * (1.0 - passes);
        transmittance *= passes;
        opacity += weight;
        distance += weight * f64::from(t[i]);
        if weight > 0.0 {
            for (sum, value) in sums.iter_mut().zip(channels) {
                *sum += weight * value;
            }
        }
    }
    if opacity as f32 == 0.0 {
        return RayResult { samples, ..RayResult::EMPTY };
    }
    let rgb = match model.field.deferred() {
        None => [sums[0], sums[1], sums[2]],
        Some(decoder) => {
            shade(decoder, &sums.map(|sum| sum / opacity), ray.direction).map(|c| opacity * c)
        }
    };
    RayResult {
        rgb: rgb.map(|c| c as f32),
        opacity: opacity as f32,
        depth: path.depth(&model.space, ray, distance / opacity) as f32,
        samples,
    }
}

/// What a field says of the point at distance `t`; `None` where it is not evaluated.
fn sample(
    model: &Model<'_>,
    field: &AnyField<'_>,
    (ray, path): (&Ray, &Path),
    t: f32,
    clipped: bool,
) -> Option<(f64, Features)> {
    let p = path.point(t)?;
    let u = if clipped { place(model, p)? } else { model.space.unit_map().apply(p) };
    Some(field.reference(u, ray.direction))
}

/// What sample i stands for.
fn delta(t: &[f32], i: usize, last: f32) -> f32 {
    t.get(i + 1).map_or(last, |next| next - t[i])
}

/// Where the part `at` of the distribution lies before.
fn inverse(t: &[f32], weights: &[f64], at: f64) -> f64 {
    let middle = |i: usize| f64::from(0.5 * (t[i] + t[i + 1]));
    let weight = |i: usize| weights[i] + 1e-5;
    let last = t.len() - 2;
    let total: f64 = (1..=last).map(weight).sum();
    let mut before = 0.0;
    for i in 1..=last {
        let part = weight(i) / total;
        if at < before + part || i == last {
            let inside = (at - before) / if part < 1e-5 { 1.0 } else { part };
            return middle(i - 1) + inside.clamp(0.0, 1.0) * (middle(i) - middle(i - 1));
        }
        before += part;
    }
    middle(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_by_hand() {
        // Middles 0.5, 1.5, 2.5, 3.5: bins of weight 0, 3 and 1.
        let (t, weights) = ([0.0, 1.0, 2.0, 3.0, 4.0], [7.0, 0.0, 3.0, 1.0, 7.0]);
        let expected = [0.5, 1.5 + 1.0 / 3.0, 1.5 + 2.0 / 3.0, 2.5, 3.5];
        for (i, expected) in expected.into_iter().enumerate() {
            let found = inverse(&t, &weights, i as f64 / 4.0);
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
        assert_eq!([delta(&t, 1, 1e10), delta(&t, 4, 1e10)], [1.0, 1e10]);
    }
}
