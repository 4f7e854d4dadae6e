//! How far normals of a model of a built-in scene are off, degrees:
//!
//! ```sh
//! cargo run --release -p pocketnerf-train --example normals -- MODEL SCENE
//! ```
//!
//! Over pixels of the validation views whose true normals are known: from the true depths of rays
//! a tenth of a pixel to each side. A normal that faces away counts as its mirror image.

use std::error::Error;

use glam::Vec3;
use pocketnerf_core::query::{Depth, normal};
use pocketnerf_core::{Camera, Model, Probe, Ray, SimdLevel, Tuning};
use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::picture::{self, Settings};
use rayon::prelude::*;

/// A prime, so that all columns have their turn.
const PIXELS_APART: usize = 13;
/// Pixels to the sides, for the truth.
const BESIDE: f32 = 0.1;
/// Neighbours lie on one surface where depths differ by less than so many times their distance.
const STEEP: f32 = 8.0;
/// Of a ball.
const POINTS: usize = 24;

/// A method and its normals.
type Found = (&'static str, Vec<Vec3>);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, name] = arguments.as_slice() else {
        return Err("expected two arguments: MODEL SCENE".into());
    };
    let scene = Scene::named(name).ok_or_else(|| format!("{name}: no such scene"))?;
    let bytes = std::fs::read(path).map_err(|e| format!("{path}: {e}"))?;
    let bytes = pocketnerf_formats::unpacked(&bytes)?;
    let file = pocketnerf_formats::open_verified(&bytes)?;
    let probe = file.probe(SimdLevel::detect(), Tuning::FAST)?;
    let mut methods: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut seen = 0;
    for view in scene.dataset(Split::Val, 1).views {
        let camera = view.camera;
        let truth = truth(scene, &camera, view.depth.as_deref().ok_or("no depths")?);
        seen += truth.len();
        for (i, (method, normals)) in
            all(&file.model, &probe, &camera, &truth)?.into_iter().enumerate()
        {
            if i == methods.len() {
                methods.push((method, Vec::new()));
            }
            let pairs = truth.iter().zip(normals).filter(|(_, normal)| *normal != Vec3::ZERO);
            methods[i].1.extend(pairs.map(|((pixel, truth), normal)| {
                let away = normal.dot(ray(&camera, *pixel).direction.into()).max(0.0);
                let normal = normal - 2.0 * away * Vec3::from(ray(&camera, *pixel).direction);
                f64::from(normal.dot(*truth).clamp(-1.0, 1.0).acos().to_degrees())
            }));
        }
    }
    for (method, mut degrees) in methods {
        degrees.sort_by(f64::total_cmp);
        let mean = degrees.iter().sum::<f64>() / degrees.len() as f64;
        let missing = 100.0 * (1.0 - degrees.len() as f64 / seen as f64);
        println!(
            "{method:36} mean {mean:5.1}, median {:5.1}, none {missing:.1} %",
            degrees[degrees.len() / 2]
        );
    }
    Ok(())
}

/// Pixels with their true normals.
fn truth(scene: Scene, camera: &Camera, depth: &[f32]) -> Vec<(usize, Vec3)> {
    let around = around(camera, BESIDE);
    let views = scene.views(&around, "around");
    let depths = views.iter().map(|view| view.depth.as_deref().unwrap_or_default());
    let depths: Vec<&[f32]> = depths.collect();
    (0..depth.len())
        .step_by(PIXELS_APART)
        .filter_map(|pixel| {
            let four = [0, 1, 2, 3].map(|k| depths[k][pixel]);
            let wide = STEEP * BESIDE * depth[pixel] / camera.focal[0];
            let near = four.iter().all(|t| (t - depth[pixel]).abs() < wide);
            near.then(|| (pixel, across(&around, pixel, four)))
        })
        .collect()
}

/// The normals of each method.
fn all(
    model: &Model<'_>,
    probe: &Probe<'_>,
    camera: &Camera,
    truth: &[(usize, Vec3)],
) -> Result<Vec<Found>, Box<dyn Error>> {
    let mut scratch = vec![0.0; probe.scratch_len()];
    let rays: Vec<Ray> = truth.iter().map(|(pixel, _)| ray(camera, *pixel)).collect();
    let mut depths = |rays: &[Ray], kind| {
        let mut depths = vec![0.0; rays.len()];
        probe.depths(rays, kind, None, &mut scratch, &mut depths).map(|()| depths)
    };
    let (means, halves) = (depths(&rays, Depth::Expected)?, depths(&rays, Depth::Median)?);
    let around = around(camera, 1.0);
    let beside = around.each_ref().map(|camera| {
        let rays: Vec<Ray> = truth.iter().map(|(pixel, _)| ray(camera, *pixel)).collect();
        depths(&rays, Depth::Median)
    });
    let [left, right, above, below] = beside;
    let beside = [left?, right?, above?, below?];

    let mut gradients = vec![[0.0; 3]; rays.len()];
    let places: Vec<[f32; 3]> =
        rays.iter().zip(&means).map(|(r, t)| at(r, *t).to_array()).collect();
    probe.density_gradient(&places, &mut scratch, &mut gradients)?;
    let plain = gradients.iter().map(|gradient| normal(*gradient).into()).collect();
    let mut four = vec![[0.0; 3]; rays.len()];
    probe.surface_normals(&rays, &means, &mut scratch, &mut four)?;
    let cells = model.occupancy.map_or(128, |occupancy| occupancy.resolution());
    let radius = probe.similarity().scale / (model.space.unit_map().scale * cells as f32);
    let step = probe.similarity().scale * model.sampling.step;
    let ball = rays.par_iter().zip(&halves).map_init(
        || vec![0.0; probe.scratch_len()],
        |scratch, (ray, t)| of_a_ball(probe, scratch, at(ray, *t), radius, 16.0 * step),
    );
    let ball = ball.collect::<Result<_, _>>()?;
    let neighbours = truth
        .iter()
        .enumerate()
        .map(|(i, (pixel, _))| across(&around, *pixel, [0, 1, 2, 3].map(|k| beside[k][i])));
    let mut planes = vec![[0.0; 3]; camera.width as usize * camera.height as usize];
    picture::normals(model, camera, &Settings::default(), &mut planes)?;
    Ok(vec![
        ("gradient at the mean depth", plain),
        ("gradients at four points around", four.into_iter().map(Vec3::from).collect()),
        ("gradient of opacity, mean of a ball", ball),
        ("neighbouring pixels", neighbours.collect()),
        ("planes", truth.iter().map(|(pixel, _)| planes[*pixel].into()).collect()),
    ])
}

/// The mean gradient of opacity over `length` in a ball, negative: by the divergence theorem, from its
/// values on the sphere.
fn of_a_ball(
    probe: &Probe<'_>,
    scratch: &mut [f32],
    center: Vec3,
    radius: f32,
    length: f32,
) -> Result<Vec3, pocketnerf_core::Error> {
    let out = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f32 / POINTS as f32;
        let (sin, cos) = (2.399_963 * i as f32).sin_cos();
        Vec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z
    };
    let points: [[f32; 3]; POINTS] = std::array::from_fn(|i| (center + radius * out(i)).to_array());
    let mut sigma = [0.0; POINTS];
    probe.density(&points, scratch, &mut sigma)?;
    let sum: Vec3 =
        sigma.iter().enumerate().map(|(i, s)| out(i) * (1.0 - (-s * length).exp())).sum();
    Ok((-sum).normalize_or_zero())
}

/// Cameras whose pixels lie to the left and right of a camera's, above and below.
fn around(camera: &Camera, pixels: f32) -> [Camera; 4] {
    [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]].map(|[x, y]: [f32; 2]| {
        let [cx, cy] = camera.center;
        Camera { center: [cx - pixels * x, cy - pixels * y], ..*camera }
    })
}

/// The normal of what these cameras see of a pixel.
fn across(around: &[Camera; 4], pixel: usize, depths: [f32; 4]) -> Vec3 {
    let [left, right, above, below] = [0, 1, 2, 3].map(|k| at(&ray(&around[k], pixel), depths[k]));
    (below - above).cross(right - left).normalize_or_zero()
}

fn ray(camera: &Camera, pixel: usize) -> Ray {
    let width = camera.width as usize;
    camera.ray((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5)
}

/// A point of a ray; where it sees nothing, one in the distance.
fn at(ray: &Ray, t: f32) -> Vec3 {
    Vec3::from(ray.origin) + t.min(1e3) * Vec3::from(ray.direction)
}
