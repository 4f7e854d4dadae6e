use super::*;
use crate::query::Depth;
use crate::render::{Detail, render_rays};
use crate::{Camera, Ray, RenderOptions};

/// Rays from above the box downwards, at many angles, that pass z = -1 inside it.
fn rays(n: usize, seed: u32) -> Vec<Ray> {
    let mut random = Random(seed);
    let mut ray = || {
        let ([x, y, _], [x2, y2, _]) = (random.point(0.9), random.point(0.9));
        let way = [x2 - x, y2 - y, -2.5];
        let length = way.iter().map(|v| v * v).sum::<f32>().sqrt();
        Ray { origin: [x, y, 1.5], direction: way.map(|v| v / length) }
    };
    (0..n).map(|_| ray()).collect()
}

/// Distance along a ray to the plane z = `z`.
fn to(ray: &Ray, z: f32) -> f32 {
    (z - ray.origin[2]) / ray.direction[2]
}

fn ask(probe: &Probe<'_>, scratch: &mut [f32], rays: &[Ray], depth: Depth) -> Vec<f32> {
    let similarity = probe.similarity();
    let turned = |d: [f32; 3]| {
        similarity.rotation.map(|row| row.iter().zip(d).map(|(r, d)| r * d).sum::<f32>())
    };
    let here = |ray: &Ray| Ray {
        origin: similarity.to_dataset(ray.origin),
        direction: turned(ray.direction),
    };
    let rays: Vec<Ray> = rays.iter().map(here).collect();
    let depth = match depth {
        Depth::FirstSigma(sigma) => Depth::FirstSigma(sigma / similarity.scale),
        other => other,
    };
    let mut out = vec![f32::NAN; rays.len()];
    probe.depths(&rays, depth, None, scratch, &mut out).unwrap();
    out.iter().map(|depth| depth / similarity.scale).collect()
}

const STEP: f32 = 0.01;

/// A wall of sigma e^8 = 2981, of which light passes 2e-4 in the mean.
#[test]
fn a_wall_stands_where_every_estimator_finds_it() {
    let rays = rays(500, 10);
    let top = wall(12);
    for kind in kinds() {
        let wall = occupancy(|[.., z]| z < 12);
        let model = Model { occupancy: Some(wall), ..fog(&kind, 0.0, 8.0) };
        each_probe(&model, |probe, scratch| {
            for depth in [Depth::Expected, Depth::Median, Depth::FirstOpacity(0.9)] {
                for (found, ray) in ask(probe, scratch, &rays, depth).iter().zip(&rays) {
                    let most = if depth == Depth::Expected { STEP } else { 0.5 * STEP + 1e-3 };
                    assert_close(*found, to(ray, top), 1e-5, most);
                }
            }
            let found = ask(probe, scratch, &rays, Depth::FirstSigma(100.0));
            for (found, ray) in found.iter().zip(&rays) {
                let behind = found - to(ray, top);
                assert!((-1e-4..STEP + 1e-4).contains(&behind), "{behind} behind the wall");
            }
        });
    }
}

/// A pane of sigma 1.6 to 2.2 and a wall of 400 and more, as of glass: what Dex-NeRF is
/// about.
#[test]
fn a_pane_before_a_wall() {
    let rays = rays(500, 11);
    let [pane, back] = [wall(26), wall(6)];
    for kind in kinds() {
        let model = Model {
            occupancy: Some(occupancy(|[.., z]| (24..26).contains(&z) || z < 6)),
            ..fog(&kind, -5.0, 3.5)
        };
        each_probe(&model, |probe, scratch| {
            for (depth, z) in [
                (Depth::FirstSigma(1.0), pane),
                (Depth::FirstOpacity(0.01), pane),
                (Depth::FirstSigma(50.0), back),
                (Depth::Median, back),
                (Depth::FirstOpacity(0.6), back),
            ] {
                for (found, ray) in ask(probe, scratch, &rays, depth).iter().zip(&rays) {
                    assert_close(*found, to(ray, z), 1e-5, 1.5 * STEP);
                }
            }
            let mean = ask(probe, scratch, &rays, Depth::Expected);
            let between =
                |(t, ray): (&f32, &Ray)| *t > to(ray, pane) + 0.1 && *t < to(ray, back) - 0.1;
            assert!(mean.iter().zip(&rays).all(between), "the mean lies where nothing is");
            let none = ask(probe, scratch, &rays, Depth::FirstSigma(1e6));
            assert!(none.iter().all(|depth| *depth == f32::INFINITY));
        });
    }
}

/// In even fog, light falls to T after -ln T / sigma.
#[test]
fn fog_by_hand() {
    let rays = rays(300, 12);
    for kind in kinds() {
        each_probe(&fog(&kind, 0.0, 1.0), |probe, scratch| {
            for (depth, part) in [
                (Depth::Median, 0.5f32),
                (Depth::FirstOpacity(0.1), 0.9),
                (Depth::FirstOpacity(0.95), 0.05),
            ] {
                for (found, ray) in ask(probe, scratch, &rays, depth).iter().zip(&rays) {
                    let expected = to(ray, 1.0) - part.ln() / 1f32.exp();
                    assert_close(*found, expected, 1e-5, 0.5 * STEP);
                }
            }
        });
    }
}

/// Those of pictures in which every pixel counts, and as deep along the camera's axis.
#[test]
fn expected_depths_are_those_of_pictures() {
    for kind in kinds() {
        let model = Model {
            occupancy: Some(tabled(occupancy(|[x, y, z]| (x / 3 + y / 5 + z / 2) % 3 == 0))),
            ..fog(&kind, 1.5, 1.0)
        };
        let pose = Camera::look_at([1.5, 0.7, 2.0], [0.0; 3], [0.0, 1.0, 0.0]);
        let camera = Camera::from_fov_x(23, 17, 1.2, pose);
        let pixels = (0..23 * 17).map(|i| ((i % 23) as f32 + 0.5, (i / 23) as f32 + 0.5));
        let rays: Vec<Ray> = pixels.map(|(x, y)| camera.ray(x, y)).collect();
        let options = RenderOptions {
            detail: Detail::FINEST,
            ..RenderOptions::new(&model, SimdLevel::compiled(), Tuning::FAST)
        };
        let mut scratch = vec![0.0; options.scratch_len()];
        let (mut rgba, mut expected) = (vec![0.0; 4 * rays.len()], vec![0.0; rays.len()]);
        render_rays(&model, &rays, &options, &mut scratch, &mut rgba, Some(&mut expected)).unwrap();
        let probe = Probe::new(&model, SimdLevel::compiled(), Tuning::FAST).unwrap();
        assert_eq!(probe.scratch_len(), options.scratch_len());
        let (mut along, mut deep) = (vec![0.0; rays.len()], vec![0.0; rays.len()]);
        probe.depths(&rays, Depth::Expected, None, &mut scratch, &mut along).unwrap();
        let axis = Some(camera.axis().map(|v| 3.0 * v));
        probe.depths(&rays, Depth::Expected, axis, &mut scratch, &mut deep).unwrap();
        let mut seen = 0;
        for (((expected, along), deep), ray) in expected.iter().zip(&along).zip(&deep).zip(&rays) {
            assert_eq!(expected.is_finite(), along.is_finite());
            if !expected.is_finite() {
                assert_eq!(*deep, f32::INFINITY);
                continue;
            }
            assert_close(*along, *expected, 1e-4, 0.0);
            let at = [0, 1, 2].map(|a| ray.origin[a] + along * ray.direction[a]);
            let [m, p] = [camera.axis(), camera.position()];
            let z: f32 = (0..3).map(|a| m[a] * (at[a] - p[a])).sum();
            assert_close(*deep, z, 1e-5, 0.0);
            seen += 1;
        }
        assert!((100..23 * 17).contains(&seen), "{seen} of {}", rays.len());
    }
}
