//! Surface normals.

use pocketnerf_core::query::{Depth, normal};
use pocketnerf_core::{Error, Probe, Ray};

/// Corners of a tetrahedron.
const AROUND: [[f32; 3]; 4] =
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// Distance along each axis from the surface to these corners, in [`Probe::gradient_step`]s;
/// a cell of the finest grid has 16.
const RADIUS: f32 = 32.0;

/// The unit normal, towards the camera, of the surface that each ray sees; `None` where half
/// of the light or more passes.
///
/// A field is rough inside objects, where nothing was ever observed: the mean direction at
/// four points around the surface is much smoother than the direction on it. `depth` holds
/// one value per ray.
///
/// # Errors
/// Those of [`Probe::depths`] and [`Probe::density_gradient`].
pub(super) fn of(
    probe: &Probe<'_>,
    rays: &[Ray],
    scratch: &mut [f32],
    depth: &mut [f32],
) -> Result<Vec<Option<[f32; 3]>>, Error> {
    probe.depths(rays, Depth::Median, None, scratch, depth)?;
    let radius = RADIUS * probe.gradient_step();
    let met = rays.iter().zip(&*depth).filter(|(_, t)| t.is_finite());
    let points: Vec<_> = met
        .flat_map(|(ray, t)| {
            let place = |a: usize| ray.origin[a] + t * ray.direction[a];
            AROUND.map(|way| [0, 1, 2].map(|a| place(a) + radius * way[a]))
        })
        .collect();
    let mut slopes = vec![[0.0; 3]; points.len()];
    probe.density_gradient(&points, scratch, &mut slopes)?;
    let mut slopes = slopes.as_chunks::<4>().0.iter();
    let normals = depth.iter().map(|t| {
        let slopes = t.is_finite().then(|| slopes.next()).flatten()?;
        let directions = slopes.map(normal);
        let sum = [0, 1, 2].map(|a| directions.iter().map(|d| d[a]).sum::<f32>());
        // `normal` negates a slope.
        Some(normal(sum.map(|v| -v)))
    });
    Ok(normals.collect())
}
