//! What is under a pixel.

use pocketnerf_core::Ray;
use pocketnerf_core::query::Depth as CoreDepth;

use crate::border;
use crate::camera::Camera;
use crate::model::Model;
use crate::options::Options;
use crate::query::probe;
use crate::status::{Error, Failure, Status, call};

/// What a ray meets.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the camera to where half of the light is absorbed, the caller's units;
    /// infinite where less is.
    pub depth: f32,
    /// That point, caller's coordinates; zero where nothing is hit.
    pub point: [f32; 3],
    /// Where the surface faces, a unit vector; zero where nothing is hit. The mean of the normals
    /// at four points around, which is smoother than that of `pnrf_normals`.
    pub normal: [f32; 3],
}

/// Rays at a time.
const RAYS: usize = 16;

/// Finds what is under `n` pixels of a camera's picture, x and y in two numbers each, from the top
/// left corner: the centre of the first pixel is at (0.5, 0.5). One hit each to `hits`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_pick(
    model: *const Model,
    options: *const Options,
    camera: *const Camera,
    pixels: *const f32,
    n: usize,
    hits: *mut Hit,
    scratch: *mut f32,
    scratch_length: usize,
    error: *mut Error,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let probe = probe(model, options)?;
        let camera = border::read(camera, "camera")?.checked()?;
        let pixels: &[[f32; 2]] = border::list(pixels.cast(), n, "pixels")?;
        if !pixels.as_flattened().iter().all(|at| at.abs() < 1e9) {
            return Err(Failure::new(Status::Argument, "pixels: expected numbers below 1e9"));
        }
        let scratch = border::room(scratch, scratch_length, "scratch")?;
        // Too little scratch is told before anything is written.
        probe.depths(&[], CoreDepth::Median, None, scratch, &mut [])?;
        let hits = border::room(hits, n, "hits")?;
        for (pixels, hits) in pixels.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            let n = pixels.len();
            let mut rays = [camera.ray(0.5, 0.5); RAYS];
            rays.iter_mut().zip(pixels).for_each(|(ray, [x, y])| *ray = camera.ray(*x, *y));
            let (mut depths, mut normals) = ([0.0; RAYS], [[0.0; 3]; RAYS]);
            let (rays, depths, normals) = (&rays[..n], &mut depths[..n], &mut normals[..n]);
            probe.depths(rays, CoreDepth::Median, None, scratch, depths)?;
            probe.surface_normals(rays, depths, scratch, normals)?;
            for (((hit, ray), depth), normal) in hits.iter_mut().zip(rays).zip(depths).zip(normals)
            {
                *hit = Hit { depth: *depth, point: point(ray, *depth), normal: *normal };
            }
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

fn point(ray: &Ray, depth: f32) -> [f32; 3] {
    match depth.is_finite() {
        true => [0, 1, 2].map(|a| ray.origin[a] + depth * ray.direction[a]),
        false => [0.0; 3],
    }
}
