//! How far the rays of a picture see, as a [`Probe`] finds it.

use pocketnerf_core::query::Depth;
use pocketnerf_core::{Camera, Error, Model, Probe, Ray, SimdLevel, Tuning};
use rayon::prelude::*;

/// The depth of what `camera` sees through the centre of each pixel, row after row; infinite where
/// it sees nothing of the kind.
///
/// # Errors
/// Whatever [`Probe`] reports: it knows models in a box alone.
pub(crate) fn depths(
    model: &Model<'_>,
    camera: &Camera,
    kind: Depth,
    simd: SimdLevel,
) -> Result<Vec<f32>, Error> {
    let probe = Probe::new(model, simd, Tuning::FAST)?;
    let width = camera.width.max(1) as usize;
    let mut depth = vec![f32::INFINITY; width * camera.height as usize];
    let memory = || (vec![0.0; probe.scratch_len()], Vec::with_capacity(width));
    depth.par_chunks_mut(width).enumerate().try_for_each_init(
        memory,
        |(scratch, rays), (y, row)| {
            rays.clear();
            rays.extend((y * width..(y + 1) * width).map(|pixel| ray(camera, pixel)));
            probe.depths(rays, kind, None, scratch, row)
        },
    )?;
    Ok(depth)
}

/// The ray through the centre of a pixel, which are counted row after row.
pub(super) fn ray(camera: &Camera, pixel: usize) -> Ray {
    let width = camera.width as usize;
    camera.ray((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5)
}
