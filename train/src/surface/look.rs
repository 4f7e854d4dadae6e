//! What a camera sees: how far away, and in which colour.

use glam::Vec3;
use pocketnerf_core::pixel::{rgb8, straight};
use pocketnerf_core::query::Depth;
use pocketnerf_core::{Camera, Error, Model};
use rayon::prelude::*;

use super::Settings;
use crate::picture::{self, Renderer, depths};

/// The longer side of a picture is at least so many times the voxels along the longest side.
const PIXELS_A_VOXEL: f32 = 2.0;
/// A surface is where so much of the light has been held back. The walls of a radiance field
/// are as thick as a sample or two: half of it is held back behind where they begin.
const BEGINS: f32 = 0.1;
/// The same of a scene that fills all pictures: nothing has told training that its air is clear,
/// and a veil of fog lies before everything.
const HALF: f32 = 0.5;
/// A scene fills all pictures where less than this share of their pixels let light pass.
const CLEAR: f64 = 0.02;

/// What one camera sees.
#[derive(Debug)]
pub(super) struct Seen {
    pub(super) camera: Camera,
    /// Euclidean, one a pixel; infinite where most of the light passes.
    pub(super) depth: Vec<f32>,
    /// sRGB, one a pixel.
    pub(super) color: Vec<[u8; 3]>,
}

/// What all of them see, in pictures that are as fine as voxels need.
pub(super) fn all(
    model: &Model<'_>,
    cameras: &[Camera],
    settings: &Settings,
    mut each: impl FnMut(usize),
) -> Result<Vec<Seen>, Error> {
    let (simd, depth) = (settings.simd, !has_box(model));
    let pictures = picture::Settings { simd, depth, ..Default::default() };
    let mut renderer = Renderer::new(model, &pictures);
    let (mut clear, mut pixels) = (0, 0);
    let mut seen = Vec::new();
    for camera in cameras {
        let camera = small(camera, settings);
        let picture = renderer.render(&camera)?;
        let rgba = picture.rgba.as_chunks::<4>().0;
        clear += rgba.iter().filter(|pixel| pixel[3] < BEGINS).count();
        pixels += rgba.len();
        let depths = picture.depth.iter().zip(rgba);
        let depth =
            depths.map(|(t, rgba)| if rgba[3] >= HALF { *t } else { f32::INFINITY }).collect();
        let space = model.display.color_space;
        let color = rgba.par_iter().map(|rgba| {
            let [r, g, b, _] = straight(*rgba);
            rgb8([r, g, b], space)
        });
        seen.push(Seen { camera, depth, color: color.collect() });
        each(seen.len());
    }
    if has_box(model) {
        let is_clear = clear as f64 >= CLEAR * pixels as f64;
        let opacity = if is_clear { BEGINS } else { HALF };
        for (i, seen) in seen.iter_mut().enumerate() {
            each(cameras.len() + i);
            // The mean depth of a pixel at an outline lies between what is before and behind it,
            // where nothing is.
            let kind = Depth::FirstOpacity(opacity);
            seen.depth = depths(model, &seen.camera, kind, settings.simd)?;
        }
    }
    Ok(seen)
}

fn small(camera: &Camera, settings: &Settings) -> Camera {
    let finest = PIXELS_A_VOXEL * settings.resolution as f32;
    let longer = camera.width.max(camera.height) as f32;
    camera.downscaled(((longer / finest) as u32).max(1))
}

/// What all pictures take.
pub(super) fn memory_bytes(cameras: &[Camera], settings: &Settings) -> u64 {
    let pixels = |camera: Camera| u64::from(camera.width) * u64::from(camera.height);
    let all: u64 = cameras.iter().map(|camera| pixels(small(camera, settings))).sum();
    all * (size_of::<f32>() + size_of::<[u8; 3]>()) as u64
}

/// Probes know no bent space; there, the mean depth alone is known.
pub(super) fn has_box(model: &Model<'_>) -> bool {
    model.space.scene_box().is_some()
}

impl Seen {
    /// Where this pixel's surface is; `None` where it sees none.
    pub(super) fn point(&self, pixel: usize) -> Option<Vec3> {
        let t = self.depth[pixel];
        let width = self.camera.width as usize;
        let ray = self.camera.ray((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
        t.is_finite().then(|| Vec3::from(ray.origin) + t * Vec3::from(ray.direction))
    }

    /// How far the surface is that this camera sees in the direction of `p`, and the nearest pixel;
    /// `None` outside of its picture. Between four pixels whose depths are within `near`, depths are
    /// interpolated.
    pub(super) fn towards(&self, p: Vec3, near: f32) -> Option<(f32, usize)> {
        let [x, y] = self.camera.project(p.to_array())?;
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
        if !inside {
            return None;
        }
        let pixel = y as usize * width + x as usize;
        let (left, top) = (x - 0.5, y - 0.5);
        let inner =
            left >= 0.0 && top >= 0.0 && (left as usize) + 1 < width && (top as usize) + 1 < height;
        if !inner {
            return Some((self.depth[pixel], pixel));
        }
        let first = top as usize * width + left as usize;
        let four = [first, first + 1, first + width, first + width + 1].map(|i| self.depth[i]);
        let (low, high) = four
            .iter()
            .fold((f32::INFINITY, 0.0_f32), |(low, high), t| (low.min(*t), high.max(*t)));
        if high - low > near || !high.is_finite() {
            return Some((self.depth[pixel], pixel));
        }
        let (u, v) = (left.fract(), top.fract());
        let row = |a: f32, b: f32| a + u * (b - a);
        let (above, below) = (row(four[0], four[1]), row(four[2], four[3]));
        Some((above + v * (below - above), pixel))
    }
}
