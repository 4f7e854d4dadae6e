//! What normalised device coordinates are beyond a box: rays in the scene's own
//! units go in, Euclidean depths come out.

use pocketnerf_core::field::Shading;
use pocketnerf_core::reference;
use pocketnerf_core::render::{Refinements, refine_tile};
use pocketnerf_core::space::Ndc;
use pocketnerf_core::{Camera, Model, Ray, Sampling, Space, Tuning};

use crate::models::{Random, Recipe, in_ndc};
use crate::picture::{self, levels, options, whole};

/// 90° wide and as high, near plane at 1: a box of 64 steps from there to infinity.
fn model(occupancy: Option<u32>) -> Model<'static> {
    let model = Recipe { occupancy, ..Recipe::PLAIN }.build();
    let space = Space::Ndc(Ndc { near: 1.0, slope: [1.0; 2], min: [-1.0; 3], max: [1.0; 3] });
    let sampling = Sampling { step: 1.0 / 32.0, near: 0.0, far: 4.0, min_transmittance: 0.0 };
    Model { space, sampling, ..model }
}

/// Every sample of a straight ray stands where its formula says: the picture of one
/// opaque step is at the depth of its middle.
#[test]
fn a_straight_ray_by_hand() {
    let mut model = model(None);
    let ray = Ray { origin: [0.0, 0.0, 0.5], direction: [0.0, 0.0, -1.0] };
    for level in levels() {
        // A box of one step, from z' = -1 + k / 32: its middle is at t' = (k + 1/2) / 64
        // of the way, at depth 1.5 + t' / (1 - t').
        for k in [0u8, 1, 20, 40, 63] {
            let low = f32::from(k) / 32.0 - 1.0;
            let (min, max) = ([-1.0, -1.0, low], [1.0, 1.0, low + 1.0 / 32.0]);
            model.space = Space::Ndc(Ndc { near: 1.0, slope: [1.0; 2], min, max });
            let found = picture::rays(&model, &[ray], &options(&model, level, Tuning::SMALL));
            assert_eq!(found.stats.samples, 1, "{level} {k}");
            let share = (f32::from(k) + 0.5) / 64.0;
            let hand = 1.5 + share / (1.0 - share);
            assert!((found.depth[0] - hand).abs() < 1e-4 * hand, "{} {hand}", found.depth[0]);
        }
    }
}

#[test]
fn rays_that_do_not_look_forwards_see_nothing() {
    let [mut seen, mut missed] = [0; 2];
    let mut random = Random(5);
    let rays: Vec<Ray> = (0..2000)
        .map(|i| {
            let origin = [0.3 * random.signed(), 0.3 * random.signed(), 2.0 * random.signed()];
            let z = [0.0, 1e-7, -1e-7, -1e-5, -0.01, -0.5, -1.0, 1.0][i % 8];
            let (x, y) = (random.signed(), random.signed());
            let length = (x * x + y * y + z * z).sqrt();
            Ray { origin, direction: [x / length, y / length, z / length] }
        })
        .collect();
    for occupancy in [None, Some(16)] {
        let model = model(occupancy);
        for level in levels() {
            let found = picture::rays(&model, &rays, &options(&model, level, Tuning::FAST));
            for (i, ray) in rays.iter().enumerate() {
                let expected = reference::render_ray(&model, ray).unwrap();
                let (alpha, depth) = (found.rgba[i][3], found.depth[i]);
                assert!((alpha - expected.opacity).abs() < 1e-3, "{ray:?}: {alpha} {expected:?}");
                if ray.direction[2] >= -1e-6 {
                    assert_eq!((found.rgba[i], depth), ([0.0; 4], f32::INFINITY));
                    missed += 1;
                } else if alpha > 0.0 {
                    // Nothing before the near plane, nor before the eye.
                    let least = (-1.0 - ray.origin[2]).min(0.0) / ray.direction[2];
                    assert!(depth >= least && depth.is_finite(), "{ray:?}: {depth}");
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 500 && missed > 500, "{seen} {missed}");
}

/// Colours depend on directions in the scene, not in the coordinates.
#[test]
fn shading_sees_the_scene() {
    for shading in [Shading::PerSample, Shading::PerRay] {
        let model = Recipe { shading, sh_degree: 4, occupancy: None, ..Recipe::PLAIN }.build();
        let model = in_ndc(model);
        // One point, seen from far aside.
        let point = [0.1f32, -0.2, -2.0];
        let eye = [1.5f32, 0.5, 0.3];
        let way = [0, 1, 2].map(|a| point[a] - eye[a]);
        let length = way.iter().map(|w| w * w).sum::<f32>().sqrt();
        let direction = way.map(|w| w / length);
        let there = reference::query(&model, point, direction).unwrap();
        let local = model.space.local(&Ray { origin: eye, direction }).unwrap();
        let other = reference::query(&model, point, local.direction).unwrap();
        let apart = (0..3).map(|c| (there.rgb[c] - other.rgb[c]).abs()).fold(0.0, f32::max);
        assert!(apart > 0.01, "a colour that depends on the direction: {apart}");
        // One sample, there.
        let image_z = 1.0 + 2.0 / point[2];
        let t = (image_z - local.origin[2]) / local.direction[2];
        let step = 1e-4;
        let sampling =
            Sampling { step, near: t - 0.5 * step, far: t + 0.6 * step, min_transmittance: 0.0 };
        let model = Model { sampling, ..model };
        for level in levels() {
            let ray = Ray { origin: eye, direction };
            let found = picture::rays(&model, &[ray], &options(&model, level, Tuning::SMALL));
            let [rgb @ .., alpha] = found.rgba[0];
            assert!(alpha > 0.0 && found.stats.samples == 1);
            assert!((found.depth[0] - length).abs() < 1e-3, "{} {length}", found.depth[0]);
            for (a, b) in rgb.iter().zip(there.rgb) {
                assert!((a / alpha - b).abs() < 2e-3, "{found:?} {there:?}");
            }
        }
    }
}

#[test]
fn refining_ends_at_the_same_picture() {
    let pose = Camera::look_at([0.2, -0.1, 0.5], [0.0, 0.0, -3.0], [0.0, 1.0, 0.0]);
    let camera = Camera::from_fov_x(50, 31, 1.2, pose);
    let model = model(Some(24));
    for level in levels() {
        let options = options(&model, level, Tuning::FAST);
        let expected = picture::tile(&model, &camera, whole(&camera), &options);
        let mut scratch = vec![0.0; options.scratch_len()];
        let (mut rgba, mut depth) = (vec![0.0; 4 * 50 * 31], vec![0.0; 50 * 31]);
        for piece in Refinements::new([50, 31], [50, 31]) {
            let depth = Some(&mut depth[..]);
            refine_tile(&model, &camera, &piece, &options, &mut scratch, &mut rgba, depth).unwrap();
        }
        assert_eq!(rgba, expected.rgba.as_flattened());
        assert_eq!(depth, expected.depth);
    }
}
