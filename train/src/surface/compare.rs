//! A mesh against the surfaces that a dataset's depths tell.

use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;

use super::mesh::Mesh;
use super::nearest::Nearest;
use crate::dataset::View;
use crate::random::Random;

/// Points on the mesh.
const SAMPLES: usize = 200_000;
/// And of the truth, about.
const TRUTH: usize = 400_000;
/// Neighbouring pixels lie on one surface where their depths differ by less than so many times
/// what a pixel is wide there.
const STEEP: f32 = 4.0;

/// How far a mesh lies from the truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SurfaceError {
    /// Mean distance from points of the mesh to the truth, in the views' units.
    pub accuracy: f64,
    /// Mean distance from the truth to points of the mesh, in the views' units.
    pub completeness: f64,
    /// The mean of both, the Chamfer distance, in percent of the diagonal of the box around the
    /// truth.
    pub chamfer_percent: f64,
    /// Mean angle between normals of the mesh and of the truth's nearest point, degrees.
    pub normal_degrees: f64,
}

/// Compares with what `views` see, in their coordinates; `None` where their depths are not known.
#[must_use]
pub fn compare(mesh: &Mesh, views: &[View]) -> Option<SurfaceError> {
    let pixels: usize = views.iter().filter_map(|view| view.depth.as_ref()).map(Vec::len).sum();
    let every = (pixels / TRUTH).max(1);
    let truth: Vec<(Vec3, Vec3)> =
        views.par_iter().flat_map_iter(|view| points(view, every)).collect();
    let (places, normals): (Vec<Vec3>, Vec<Vec3>) = truth.into_iter().unzip();
    let (samples, facing) = samples(mesh);
    let (there, here) = (Nearest::of(&places)?, Nearest::of(&samples)?);
    let [accuracy, degrees] = samples
        .par_iter()
        .zip(&facing)
        .map(|(point, normal)| {
            let (number, distance) = there.to(*point);
            let angle = normal.dot(normals[number]).clamp(-1.0, 1.0).acos().to_degrees();
            [f64::from(distance), f64::from(angle)]
        })
        .collect::<Vec<_>>()
        .iter()
        .fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
        .map(|sum| sum / samples.len() as f64);
    let far: Vec<f64> = places.par_iter().map(|point| f64::from(here.to(*point).1)).collect();
    let completeness = far.iter().sum::<f64>() / far.len() as f64;
    let (low, high) =
        places.iter().fold((places[0], places[0]), |(low, high), p| (low.min(*p), high.max(*p)));
    let diagonal = f64::from(low.distance(high));
    Some(SurfaceError {
        accuracy,
        completeness,
        chamfer_percent: 100.0 * 0.5 * (accuracy + completeness) / diagonal.max(f64::MIN_POSITIVE),
        normal_degrees: degrees,
    })
}

/// What a view sees of surfaces, and how these face; one pixel in so many, where four
/// neighbours lie on one surface.
fn points(view: &View, every: usize) -> Vec<(Vec3, Vec3)> {
    let (camera, Some(depth)) = (&view.camera, &view.depth) else { return Vec::new() };
    let (width, height) = (camera.width as usize, camera.height as usize);
    let at = |x: usize, y: usize| {
        let ray = camera.ray(x as f32 + 0.5, y as f32 + 0.5);
        Vec3::from(ray.origin) + depth[y * width + x] * Vec3::from(ray.direction)
    };
    let mut points = Vec::new();
    for pixel in (0..width * height).step_by(every) {
        let (x, y) = (pixel % width, pixel / width);
        let is_inner = x > 0 && y > 0 && x + 1 < width && y + 1 < height;
        if !is_inner || !depth[pixel].is_finite() {
            continue;
        }
        let wide = STEEP * depth[pixel] / camera.focal[0];
        let around = [pixel - 1, pixel + 1, pixel - width, pixel + width];
        if around.iter().all(|other| (depth[*other] - depth[pixel]).abs() < wide) {
            let right = at(x + 1, y) - at(x - 1, y);
            let down = at(x, y + 1) - at(x, y - 1);
            points.push((at(x, y), down.cross(right).normalize_or_zero()));
        }
    }
    points
}

/// Points spread evenly over a mesh, and its normals there.
fn samples(mesh: &Mesh) -> (Vec<Vec3>, Vec<Vec3>) {
    let mut random = Random::new(0, [0; 3]);
    let each = mesh.area() / SAMPLES as f64;
    let (mut owed, mut places, mut normals) = (0.0, Vec::new(), Vec::new());
    for triangle in &mesh.triangles {
        owed += f64::from(mesh.area_of(*triangle)) / each.max(f64::MIN_POSITIVE);
        let [a, b, c] = mesh.corners(*triangle);
        let [na, nb, nc] = triangle.map(|vertex| Vec3::from(mesh.normals[vertex as usize]));
        while owed >= 1.0 {
            owed -= 1.0;
            let (mut u, mut v) = (random.next_f32(), random.next_f32());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            places.push(a + u * (b - a) + v * (c - a));
            normals.push((na + u * (nb - na) + v * (nc - na)).normalize_or_zero());
        }
    }
    (places, normals)
}
