//! From bodies and a camera to pixels and depths.

use super::scene::Body;
use super::shading::{Lamp, SAMPLES, shade};
use super::shapes::Hit;
use super::surface::Surface;
use glam::DVec3;
use pocketnerf_core::Camera;
use rayon::prelude::*;

/// Side of the square of pixels that shares a list of bodies.
const TILE: usize = 8;
/// Where a pixel is sampled: 16 points of which no two share a row or a column
/// of a 16 × 16 grid. The first four do the same for a 4 × 4 grid.
const PATTERN: [[u8; 2]; SAMPLES] = [
    [1, 4],
    [7, 13],
    [8, 2],
    [14, 11],
    [0, 0],
    [2, 8],
    [3, 12],
    [4, 1],
    [5, 5],
    [6, 9],
    [9, 6],
    [10, 10],
    [11, 14],
    [12, 3],
    [13, 7],
    [15, 15],
];
/// Four samples whose colours lie closer than this stand for all sixteen.
const SPREAD: f64 = 0.02;

/// Straight RGBA, and the distance along the ray through each pixel's centre
/// (infinite where it meets nothing), both row after row from the top.
pub(super) fn view(bodies: &[Body], camera: &Camera) -> (Vec<u8>, Vec<f32>) {
    let (width, height) = (camera.width as usize, camera.height as usize);
    let lamp = Lamp::new();
    let mut rgba = vec![0; width * height * 4];
    let mut depth = vec![f32::INFINITY; width * height];
    rgba.par_chunks_mut(width * 4 * TILE)
        .zip(depth.par_chunks_mut(width * TILE))
        .enumerate()
        .for_each(|(row, (rgba, depth))| {
            let rows = depth.len() / width;
            for left in (0..width).step_by(TILE) {
                let right = (left + TILE).min(width);
                let tile = Tile::new(
                    bodies,
                    camera,
                    &lamp,
                    [left, row * TILE],
                    [right, row * TILE + rows],
                );
                if tile.near.is_empty() {
                    continue;
                }
                for y in 0..rows {
                    for x in left..right {
                        let i = y * width + x;
                        let (colour, distance) = tile.pixel(x, row * TILE + y);
                        rgba[4 * i..4 * i + 4].copy_from_slice(&colour);
                        depth[i] = distance;
                    }
                }
            }
        });
    (rgba, depth)
}

/// A square of pixels and the bodies that can be seen in it.
struct Tile<'a> {
    bodies: &'a [Body],
    camera: &'a Camera,
    lamp: &'a Lamp,
    origin: DVec3,
    /// Indices of the bodies.
    near: Vec<usize>,
    /// Whether a wire is among them: four samples could all miss it.
    has_wire: bool,
}

impl<'a> Tile<'a> {
    /// The pixels from `low` up to `high`.
    fn new(
        bodies: &'a [Body],
        camera: &'a Camera,
        lamp: &'a Lamp,
        low: [usize; 2],
        high: [usize; 2],
    ) -> Self {
        let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]) as f64);
        let (origin, axis) = ray(camera, middle[0], middle[1]);
        // The cone around the tile: a corner's cosine, the smallest of all.
        let cosine = [[low[0], low[1]], [high[0], low[1]], [low[0], high[1]], [high[0], high[1]]]
            .iter()
            .map(|c| ray(camera, c[0] as f64, c[1] as f64).1.dot(axis))
            .fold(1.0, f64::min);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let touches = |body: &Body| {
            (0..body.shape.parts()).any(|part| {
                let (center, radius) = body.shape.bound(part);
                let towards = center - origin;
                let distance = towards.length();
                let ball_sine = radius / distance;
                let ball_cosine = (1.0 - ball_sine * ball_sine).sqrt();
                towards.dot(axis) >= distance * (cosine * ball_cosine - sine * ball_sine)
            })
        };
        let near: Vec<_> = (0..bodies.len()).filter(|&i| touches(&bodies[i])).collect();
        let has_wire = near.iter().any(|&i| bodies[i].surface == Surface::Wire);
        Self { bodies, camera, lamp, origin, near, has_wire }
    }

    /// Colour and depth of pixel (`x`, `y`).
    fn pixel(&self, x: usize, y: usize) -> ([u8; 4], f32) {
        let (x, y) = (x as f64, y as f64);
        let centre = self.first(ray(self.camera, x + 0.5, y + 0.5).1);
        let depth = centre.map_or(f32::INFINITY, |(_, hit)| hit.t as f32);

        let mut sum = DVec3::ZERO;
        let mut covered = 0;
        let mut alike = !self.has_wire;
        let mut range = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut taken = 0;
        for (i, [dx, dy]) in PATTERN.iter().enumerate() {
            if i == 4 && alike && (range[1] - range[0]).max_element() < SPREAD {
                break;
            }
            let offset = |d: u8| (f64::from(d) + 0.5) / SAMPLES as f64;
            let direction = ray(self.camera, x + offset(*dx), y + offset(*dy)).1;
            let found = self.first(direction);
            if let Some((body, hit)) = found {
                let colour = shade(self.bodies, body, hit, self.origin, direction, self.lamp, i);
                range = [range[0].min(colour), range[1].max(colour)];
                sum += colour;
                covered += 1;
                alike &= !self.bodies[body].surface.is_fine();
            }
            alike &= found.map(|f| f.0) == centre.map(|c| c.0);
            taken += 1;
        }
        if covered == 0 {
            return ([0; 4], depth);
        }
        let quantised = |x: f64| (x * 255.0 + 0.5) as u8;
        let [r, g, b] = (sum / f64::from(covered)).to_array().map(quantised);
        ([r, g, b, quantised(f64::from(covered) / f64::from(taken))], depth)
    }

    /// The first body along `direction`.
    fn first(&self, direction: DVec3) -> Option<(usize, Hit)> {
        let mut first: Option<(usize, Hit)> = None;
        for &i in &self.near {
            if let Some(hit) = self.bodies[i].shape.enter(self.origin, direction)
                && first.is_none_or(|(_, other)| hit.t < other.t)
            {
                first = Some((i, hit));
            }
        }
        first
    }
}

/// Origin and unit direction of the ray through an image point, pixels.
pub(super) fn ray(camera: &Camera, x: f64, y: f64) -> (DVec3, DVec3) {
    let ray = camera.ray(x as f32, y as f32);
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    (origin, direction.normalize())
}
