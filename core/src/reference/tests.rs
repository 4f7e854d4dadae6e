//! Whole rays through small models, by hand.

extern crate std;

use super::testing::{ALONG_Z, Kind, SceneBuilder, dense, kinds, tensor};
use super::*;
use crate::field::Shading;
use crate::network::{Dense, Mlp};
use crate::{Occupancy, Space};

const SHADINGS: [Shading; 2] = [Shading::PerSample, Shading::PerRay];

mod unusable;

fn close(found: f32, hand: f64) {
    let error = (f64::from(found) - hand).abs();
    assert!(error <= 1.2e-7 * hand.abs().max(1e-3), "{found}, by hand {hand}");
}

/// 1 / (1 + e^-x), of the standard library.
fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// Density e^`raw` and colour logistic(`color`) everywhere in the box.
fn constant(kind: &Kind, raw: f32, color: [f32; 3], shading: Shading) -> SceneBuilder {
    let mut scene = SceneBuilder::new(kind, [0.0; 3], [raw, 0.0, 0.0]);
    scene.set_color(&[dense(3, 3, &[0.0; 9], &color)]);
    scene.decoder.shading = shading;
    scene
}

#[test]
fn a_box_of_constant_density() {
    // Samples at t = 2.125, 2.375 ... 3.875: eight of 0.25 cover the box's length of 2, so
    // opacity is 1 - e^(-2 sigma) exactly.
    for kind in kinds() {
        for shading in SHADINGS {
            let scene = constant(&kind, -0.5, [0.0, 2.0, -1.0], shading).build();
            let seen = render_ray(&scene, &ALONG_Z).unwrap();
            let opacity = 1.0 - (-2.0 * (-0.5f64).exp()).exp();
            assert_eq!(seen.samples, 8);
            close(seen.opacity, opacity);
            for (found, color) in seen.rgb.into_iter().zip([0.0, 2.0, -1.0]) {
                close(found, opacity * logistic(color));
            }
            for (found, color) in seen.over([0.25; 3]).into_iter().zip([0.0, 2.0, -1.0]) {
                close(found, opacity * logistic(color) + (1.0 - opacity) * 0.25);
            }
        }
    }
}

#[test]
fn depth_by_hand() {
    // Steps of 1 from near = 0: t = 2.5 and 3.5 lie in the box. Sigma is 1, so both have
    // alpha = 1 - 1/e, and w = alpha, alpha / e.
    for kind in kinds() {
        for shading in SHADINGS {
            let mut scene = constant(&kind, 0.0, [0.0; 3], shading);
            scene.sampling.step = 1.0;
            scene.sampling.near = 0.0;
            let seen = render_ray(&scene.build(), &ALONG_Z).unwrap();
            let e = core::f64::consts::E;
            assert_eq!(seen.samples, 2);
            close(seen.opacity, 1.0 - 1.0 / (e * e));
            close(seen.depth, (2.5 + 3.5 / e) / (1.0 + 1.0 / e));
        }
    }
}

#[test]
fn five_samples_of_doubling_density() {
    // The rows of the table in `ray`, through whole models: steps of 0.4 from near = 2 put
    // samples at z = -0.8, -0.4, 0, 0.4, 0.8. ln sigma = ln(ln 2 / 0.4) + ln 2 (z + 0.8) / 0.4.
    let ln_2 = core::f64::consts::LN_2;
    for kind in kinds() {
        let slope = ln_2 / 0.4;
        let bias = slope.ln() + 0.8 * slope;
        let mut scene = SceneBuilder::new(&kind, [slope as f32, 0.0, 0.0], [bias as f32, 0.0, 0.0]);
        scene.sampling.step = 0.4;
        scene.sampling.near = 2.0;
        let weights =
            [1.0 / 2.0, 3.0 / 8.0, 15.0 / 128.0, 255.0 / 32768.0, 65535.0 / 2_147_483_648.0];
        // T falls below 0.2 after sample 1, which still counts, and below 0.01 after sample 2.
        for (min_transmittance, samples) in [(0.0, 5), (0.2, 2), (0.01, 3)] {
            scene.sampling.min_transmittance = min_transmittance;
            let seen = render_ray(&scene.build(), &ALONG_Z).unwrap();
            let taken = &weights[..samples];
            let total: f64 = taken.iter().sum();
            // A ray that ended early counts as opaque.
            let opacity = if samples < 5 { 1.0 } else { total };
            let distance: f64 =
                taken.iter().enumerate().map(|(k, w)| w * (2.2 + 0.4 * k as f64)).sum();
            assert_eq!(seen.samples, samples as u32);
            assert!((f64::from(seen.opacity) - opacity).abs() < 1e-6);
            assert!((f64::from(seen.depth) - distance / total).abs() < 1e-6);
        }
    }
}

#[test]
fn per_sample_averages_colors_and_per_ray_features() {
    // Two samples at z = -0.5 and 0.5 with alpha 1/2: w = 1/2, 1/4. Feature 0 is 4 z, and red
    // is its logistic. Per sample: logistic(-2) / 2 + logistic(2) / 4. Per ray: the mean
    // feature is (-2 / 2 + 2 / 4) / (3 / 4) = -2/3.
    for kind in kinds() {
        let raw = core::f64::consts::LN_2.ln() as f32;
        let mut scene = SceneBuilder::new(&kind, [0.0, 4.0, 0.0], [raw, 0.0, 0.0]);
        scene.set_color(&[dense(3, 3, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 3])]);
        scene.sampling.step = 1.0;
        for (shading, red) in [
            (Shading::PerSample, logistic(-2.0) / 2.0 + logistic(2.0) / 4.0),
            (Shading::PerRay, 0.75 * logistic(-2.0 / 3.0)),
        ] {
            scene.decoder.shading = shading;
            let seen = render_ray(&scene.build(), &ALONG_Z).unwrap();
            assert!((f64::from(seen.opacity) - 0.75).abs() < 1e-7);
            assert!((f64::from(seen.rgb[0]) - red).abs() < 1e-7, "{shading:?}");
            assert!((f64::from(seen.rgb[1]) - 0.75 * 0.5).abs() < 1e-7);
        }
    }
}

#[test]
fn color_depends_on_the_direction() {
    // Degree 2, blue reads harmonic 2 = 0.4886 z through a weight of 10: opposite ways along z
    // have opposite logits.
    for kind in kinds() {
        for shading in SHADINGS {
            let mut scene = constant(&kind, 15.0, [0.0; 3], shading);
            scene.decoder.sh_degree = 2;
            let mut weight = [0.0; 18];
            weight[4 * 3 + 2] = 10.0;
            scene.set_color(&[dense(6, 3, &weight, &[0.0; 3])]);
            let model = scene.build();
            for (z, origin) in [(1.0, -3.0), (-1.0, 3.0)] {
                let ray = Ray { origin: [0.0, 0.0, origin], direction: [0.0, 0.0, z] };
                let seen = render_ray(&model, &ray).unwrap();
                close(seen.rgb[2], logistic(f64::from(z) * 4.886_025_119_029_199));
                close(seen.rgb[0], 0.5);
            }
        }
    }
}

#[test]
fn opacity_0_is_exactly_the_background() {
    let background = [0.1, 0.7, 1.0 / 3.0];
    let beside = Ray { origin: [2.0, 0.0, -3.0], ..ALONG_Z };
    for kind in kinds() {
        for shading in SHADINGS {
            let misses = render_ray(&constant(&kind, 3.0, [1.0; 3], shading).build(), &beside);
            let thin = render_ray(&constant(&kind, -1e4, [1.0; 3], shading).build(), &ALONG_Z);
            assert_eq!(misses.unwrap(), RayResult::EMPTY);
            assert_eq!(thin.unwrap(), RayResult { samples: 8, ..RayResult::EMPTY });
            assert_eq!(thin.unwrap().over(background), background);
        }
    }
}

#[test]
fn color_never_exceeds_opacity() {
    for kind in kinds() {
        for shading in SHADINGS {
            for raw in [-9.0, -1.0, 0.3, 2.0, 15.0] {
                let scene = constant(&kind, raw, [1e3, 30.0, 2.0], shading).build();
                let seen = render_ray(&scene, &ALONG_Z).unwrap();
                assert!(seen.opacity > 0.0 && seen.opacity <= 1.0);
                assert!(seen.rgb.iter().all(|c| *c <= seen.opacity));
            }
        }
    }
}

#[test]
fn samples_lie_on_the_global_grid_within_near_and_far() {
    for kind in kinds() {
        let mut scene = constant(&kind, 0.0, [0.0; 3], Shading::PerSample);
        // From inside the box: near = 0 and far = 0.75 leave t = 0.125, 0.375, 0.625.
        let inside = Ray { origin: [0.0; 3], direction: [0.0, 0.0, 1.0] };
        scene.sampling.near = 0.0;
        scene.sampling.far = 0.75;
        let seen = render_ray(&scene.build(), &inside).unwrap();
        assert_eq!(seen.samples, 3);
        close(seen.opacity, 1.0 - (-0.75f64).exp());
        // A grid that does not fit the box: near = 0.1 puts samples at 0.225, 0.475, 0.725,
        // 0.975 and then 1.225, outside.
        scene.sampling.near = 0.1;
        scene.sampling.far = 6.0;
        assert_eq!(render_ray(&scene.build(), &inside).unwrap().samples, 4);
        // The faces belong to the box: t = 1.0 and 3.0 are the first and last of steps of 1.
        scene.sampling.step = 1.0;
        scene.sampling.near = 0.5;
        let face = Ray { origin: [1.0, -1.0, -2.0], direction: [0.0, 0.0, 1.0] };
        assert_eq!(render_ray(&scene.build(), &face).unwrap().samples, 3);
    }
}

#[test]
fn a_clear_bit_clears_a_sample() {
    // 8³ cells of 0.25: each sample along z lies in a cell of its own. The ray's x = 0.1 is in
    // cell 4, y = -0.2 in cell 3.
    let coarse = [1, 0];
    let mut fine = [0xff; 64];
    fine[3 + 8 * 5] &= !(1 << 4);
    let occupancy = Occupancy::new(8, 1, &coarse, &fine).unwrap();
    for kind in kinds() {
        for shading in SHADINGS {
            let mut model = constant(&kind, 0.0, [0.0; 3], shading).build();
            model.occupancy = Some(occupancy);
            let seen = render_ray(&model, &ALONG_Z).unwrap();
            assert_eq!(seen.samples, 7);
            close(seen.opacity, 1.0 - (-1.75f64).exp());
            // Cell z = 5 is the scene's z = 0.25 to 0.5.
            let d = [0.0, 0.0, 1.0];
            assert_eq!(query(&model, [0.1, -0.2, 0.3], d).unwrap().sigma, 0.0);
            assert_eq!(query(&model, [0.1, -0.2, 0.2], d).unwrap().sigma, 1.0);
            // No bit at all: nothing is asked.
            model.occupancy = Some(Occupancy::new(8, 1, &[0, 0], &[]).unwrap());
            assert_eq!(render_ray(&model, &ALONG_Z), Ok(RayResult::EMPTY));
        }
    }
}

#[test]
fn a_point_by_hand() {
    // sigma = e^(2 z - 1), red = logistic(3 z), the rest 1/2.
    for kind in kinds() {
        for shading in SHADINGS {
            let mut scene = SceneBuilder::new(&kind, [2.0, 3.0, 0.0], [-1.0, 0.0, 0.0]);
            scene.set_color(&[dense(
                3,
                3,
                &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                &[0.0; 3],
            )]);
            scene.decoder.shading = shading;
            let model = scene.build();
            let point = query(&model, [0.3, 0.4, 0.75], [0.0, 0.0, 1.0]).unwrap();
            close(point.sigma, 0.5f64.exp());
            close(point.rgb[0], logistic(2.25));
            assert_eq!(point.rgb[1..], [0.5; 2]);
            let outside = query(&model, [0.3, 0.4, 1.01], [0.0, 0.0, 1.0]).unwrap();
            assert_eq!(outside, PointResult { sigma: 0.0, rgb: [0.0; 3] });
        }
    }
}

#[test]
fn shorter_sides_use_part_of_the_unit_cube() {
    // A box of 1 × 1 × 4 scene units: 2 u.z - 1 is 0.5 z - 1 for z in [0, 4], x and y end at u = 1/4.
    for kind in kinds() {
        let mut model = SceneBuilder::new(&kind, [1.0, 0.0, 0.0], [0.0; 3]).build();
        model.space = Space::Box { min: [0.0; 3], max: [1.0, 1.0, 4.0] };
        let sigma = |p| query(&model, p, [0.0, 0.0, 1.0]).unwrap().sigma;
        close(sigma([0.5, 0.5, 3.0]), 0.5f64.exp());
        close(sigma([1.0, 0.0, 4.0]), 1f64.exp());
        assert_eq!(sigma([1.1, 0.5, 3.0]), 0.0);
    }
}

#[test]
fn pixels_tiles_and_pictures_agree() {
    let pose = Camera::look_at([1.0, 2.0, 3.0], [0.0; 3], [0.0, 1.0, 0.0]);
    let camera = Camera::from_fov_x(5, 3, 1.0, pose);
    for kind in kinds() {
        let model = SceneBuilder::new(&kind, [1.0, 2.0, 0.0], [0.0; 3]).build();
        let mut picture = [RayResult::EMPTY; 15];
        render_picture(&model, &camera, &mut picture).unwrap();
        let mut tile = [RayResult::EMPTY; 4];
        render_tile(&model, &camera, [2, 1], [2, 2], &mut tile).unwrap();
        assert_eq!(tile, [picture[7], picture[8], picture[12], picture[13]]);
        for (i, seen) in picture.iter().enumerate() {
            let (x, y) = (i as u32 % 5, i as u32 / 5);
            assert_eq!(render_pixel(&model, &camera, x, y), Ok(*seen));
            let through_centre = camera.ray(x as f32 + 0.5, y as f32 + 0.5);
            assert_eq!(render_ray(&model, &through_centre), Ok(*seen));
        }
        assert!(picture[7].opacity > 0.5);
        let short = render_picture(&model, &camera, &mut picture[..14]);
        assert_eq!(short, Err(Error::OutputLength { needed: 15, given: 14 }));
        assert_eq!(render_tile(&model, &camera, [0, 0], [0, 9], &mut []), Ok(()));
    }
}
