//! Questions to a model against the oracle: every kind of field, every stored type, every
//! shading, at every SIMD level of this machine.

use pocketnerf_core::query::Depth;
use pocketnerf_core::reference::{self, PointResult, RayResult};
use pocketnerf_core::{Model, Probe, Ray, Sampling, Space, Tuning};

use crate::models::{Random, Recipe};
use crate::picture::{GARBAGE, levels};

/// Most that a density may differ, a part of it: what the logarithm of a density may
/// differ as a sum of f32 products, which ends a density network, from one of f64.
const SIGMA: f32 = 3e-4;
/// And so much, 1 / unit: next to 0, what ReLU lets pass is a small difference of large sums.
const NEXT_TO_NOTHING: f32 = 2e-5;
/// Most that a colour may differ: f32 against f64 through a network and a logistic.
const COLOR: f32 = 3e-5;

/// Points in and around the box, and unit vectors.
fn places(model: &Model<'_>, n: usize) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let mut random = Random(n as u64);
    let Space::Box { min, max } = model.space else { unreachable!("a new kind of space") };
    let mut point = || [0, 1, 2].map(|a| min[a] + (1.1 * random.unit() - 0.05) * (max[a] - min[a]));
    let points = (0..n).map(|_| point()).collect();
    let mut direction = || {
        let d = [random.signed(), random.signed(), random.signed()];
        let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
        d.map(|v| v / length)
    };
    (points, (0..n).map(|_| direction()).collect())
}

/// Probes of every level and size, with scratch of exactly the promised length.
fn each_probe(model: &Model<'_>, mut ask: impl FnMut(&Probe<'_>, &mut [f32], &str)) {
    for level in levels() {
        for tuning in [Tuning::SMALL, Tuning::FAST] {
            let probe = Probe::new(model, level, tuning).unwrap();
            let mut scratch = vec![GARBAGE; probe.scratch_len()];
            ask(&probe, &mut scratch, &format!("{level} {tuning:?}"));
        }
    }
}

#[test]
fn density_and_radiance() {
    let (mut evaluated, mut worst) = (0, [0.0f32; 2]);
    for recipe in Recipe::all() {
        let model = recipe.build();
        let (points, directions) = places(&model, 200);
        let both = points.iter().zip(&directions);
        let expected: Vec<PointResult> =
            both.map(|(p, d)| reference::query(&model, *p, *d).unwrap()).collect();
        evaluated += expected.iter().filter(|result| result.sigma > 0.0).count();
        each_probe(&model, |probe, scratch, what| {
            let mut sigma = vec![GARBAGE; points.len()];
            probe.density(&points, scratch, &mut sigma).unwrap();
            let mut rgbs = vec![[GARBAGE; 4]; points.len()];
            probe.radiance(&points, &directions, scratch, &mut rgbs).unwrap();
            for (i, expected) in expected.iter().enumerate() {
                let [rgb @ .., sigma_too] = rgbs[i];
                for sigma in [sigma[i], sigma_too] {
                    let off = (sigma - expected.sigma).abs();
                    let most = SIGMA * expected.sigma + NEXT_TO_NOTHING.min(expected.sigma);
                    assert!(off <= most, "{recipe:?} {what} {i}: {sigma}, {expected:?}");
                    worst[0] = worst[0].max(off / expected.sigma.max(0.1));
                }
                for (c, expected) in rgb.iter().zip(expected.rgb) {
                    let off = (c - expected).abs();
                    assert!(off <= COLOR, "{recipe:?} {what} {i}: {rgb:?}, {expected:?}");
                    worst[1] = worst[1].max(off);
                }
            }
        });
    }
    println!("{evaluated} points; worst: sigma {:e} of it, colour {:e}", worst[0], worst[1]);
    assert!(evaluated > 3000, "{evaluated} points in occupied cells");
}

/// The same differences, of the oracle's densities. What is left is rounding: of densities,
/// a part in 50,000, over two steps.
#[test]
fn gradients() {
    let (mut evaluated, mut worst) = (0, 0.0f64);
    for recipe in Recipe::all() {
        let model = recipe.build();
        let everywhere = Model { occupancy: None, ..model };
        let Space::Box { min, max } = model.space else { unreachable!("a new kind of space") };
        let (points, _) = places(&model, 60);
        each_probe(&model, |probe, scratch, what| {
            let mut found = vec![[GARBAGE; 3]; points.len()];
            probe.density_gradient(&points, scratch, &mut found).unwrap();
            let h = probe.gradient_step();
            for (p, found) in points.iter().zip(&found) {
                if !probe.occupied(*p) {
                    assert_eq!(*found, [0.0; 3]);
                    continue;
                }
                // Nearer to a face than a step, differences are one-sided.
                if (0..3).any(|a| p[a] - h < min[a] || p[a] + h > max[a]) {
                    continue;
                }
                let sigma =
                    |p| f64::from(reference::query(&everywhere, p, [0.0, 0.0, 1.0]).unwrap().sigma);
                let here = sigma(*p);
                for axis in 0..3 {
                    let moved = |by: f32| {
                        let mut moved = *p;
                        moved[axis] += by;
                        moved
                    };
                    let [low, high] = [moved(-h), moved(h)];
                    let expected = (sigma(high) - sigma(low)) / f64::from(high[axis] - low[axis]);
                    let off = (f64::from(found[axis]) - expected).abs();
                    let rounding = here.max(sigma(high)) / (2.0 * f64::from(h));
                    worst = worst.max((off - 1e-3 * expected.abs()) / rounding);
                    assert!(
                        off <= 1e-3 * expected.abs() + 2e-5 * rounding,
                        "{recipe:?} {what} {p:?} along {axis}: {}, {expected}",
                        found[axis]
                    );
                }
                evaluated += 1;
            }
        });
    }
    println!("{evaluated} points; worst rounding {worst:e} of sigma over two steps");
    assert!(evaluated > 10_000, "{evaluated} points");
}

/// A ray whose samples are those of the segment.
#[test]
fn transmittances() {
    let (mut evaluated, mut worst) = (0, 0.0f32);
    for recipe in Recipe::all() {
        let model = recipe.build();
        let (points, _) = places(&model, 120);
        // Inside the box, so that none of it is cut off.
        let Space::Box { min, max } = model.space else { unreachable!("a new kind of space") };
        let inside = |p: &[f32; 3]| [0, 1, 2].map(|a| p[a].clamp(min[a], max[a]));
        let segments: Vec<[[f32; 3]; 2]> =
            points.as_chunks::<2>().0.iter().map(|[a, b]| [inside(a), inside(b)]).collect();
        let expected = segments.iter().map(|[a, b]| {
            let way = [0, 1, 2].map(|i| b[i] - a[i]);
            let length = way.iter().map(|v| v * v).sum::<f32>().sqrt();
            let steps = (length / model.sampling.step).floor() + 1.0;
            let ray = Ray { origin: *a, direction: way.map(|v| v / length) };
            let (step, near, far) = (length / steps, 0.0, length);
            let sampling = Sampling { step, near, far, min_transmittance: 0.0 };
            let model = Model { sampling, ..model };
            1.0 - reference::render_ray(&model, &ray).unwrap().opacity
        });
        let expected: Vec<f32> = expected.collect();
        evaluated += expected.iter().filter(|passes| (0.01..0.99).contains(*passes)).count();
        each_probe(&model, |probe, scratch, what| {
            let mut found = vec![GARBAGE; segments.len()];
            probe.segment_transmittance(&segments, scratch, &mut found).unwrap();
            for ((found, expected), segment) in found.iter().zip(&expected).zip(&segments) {
                let off = (found - expected).abs();
                worst = worst.max(off);
                assert!(off <= 1e-4, "{recipe:?} {what} {segment:?}: {found}, {expected}");
            }
        });
    }
    println!("{evaluated} segments in mist; worst {worst:e}");
    assert!(evaluated > 500, "{evaluated} segments in mist");
}

/// Expected depths are the oracle's.
#[test]
fn depths() {
    let mut seen = 0;
    for recipe in Recipe::all() {
        let model = recipe.build();
        let (targets, directions) = places(&model, 60);
        let both = targets.iter().zip(&directions);
        let rays: Vec<Ray> = both
            .map(|(p, d)| Ray { origin: [0, 1, 2].map(|a| p[a] - 2.5 * d[a]), direction: *d })
            .collect();
        let expected: Vec<RayResult> =
            rays.iter().map(|ray| reference::render_ray(&model, ray).unwrap()).collect();
        each_probe(&model, |probe, scratch, what| {
            let mut found = vec![GARBAGE; rays.len()];
            probe.depths(&rays, Depth::Expected, None, scratch, &mut found).unwrap();
            for (found, expected) in found.iter().zip(&expected) {
                if !found.is_finite() {
                    assert!(expected.opacity < 1e-6, "{recipe:?} {what}: {expected:?}");
                    continue;
                }
                let off = (found - expected.depth).abs() * expected.opacity;
                assert!(off <= 1e-3, "{recipe:?} {what}: {found}, {expected:?}");
                seen += 1;
            }
        });
    }
    assert!(seen > 10_000, "{seen} depths");
}
