//! From a scene and a camera to pixels and depths.

use super::contents::Contents;
use super::tile::Tile;
use glam::DVec3;
use pocketnerf_core::Camera;
use rayon::prelude::*;

/// Side of the square of pixels that shares a list of bodies.
const TILE: usize = 8;

/// Straight RGBA, and the distance along the ray through each pixel's centre
/// (infinite where it meets nothing), both row after row from the top.
pub(super) fn view(contents: &Contents, camera: &Camera) -> (Vec<u8>, Vec<f32>) {
    let (width, height) = (camera.width as usize, camera.height as usize);
    let mut rgba = vec![0; width * height * 4];
    let mut depth = vec![f32::INFINITY; width * height];
    rgba.par_chunks_mut(width * 4 * TILE)
        .zip(depth.par_chunks_mut(width * TILE))
        .enumerate()
        .for_each(|(row, (rgba, depth))| {
            let rows = depth.len() / width;
            for left in (0..width).step_by(TILE) {
                let right = (left + TILE).min(width);
                let tile =
                    Tile::new(contents, camera, [left, row * TILE], [right, row * TILE + rows]);
                if tile.is_empty() {
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

/// Origin and unit direction of the ray through an image point, pixels.
pub(super) fn ray(camera: &Camera, x: f64, y: f64) -> (DVec3, DVec3) {
    let ray = camera.ray(x as f32, y as f32);
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    (origin, direction.normalize())
}
