//! Where the surfaces face that rays see.

use core::array::from_fn;

use crate::query::points::{DIRECTION, check_output, check_points, unit};
use crate::query::{Probe, normal};
use crate::{Error, Ray};

/// Corners of a tetrahedron.
const AROUND: [[f32; 3]; 4] =
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// Distance along each axis from the surface to these corners, in [`Probe::gradient_step`]s;
/// a cell of the finest grid has 16.
const RADIUS: f32 = 32.0;

/// Rays at a time: their points are on the stack.
const RAYS: usize = 16;

impl Probe<'_> {
    /// The normals of what `rays` see at `depths`, distances in the caller's units as
    /// [`depths`](Self::depths) finds them: a unit vector each into `out`, the caller's axes; zeros
    /// where the depth is infinite or nothing has a slope.
    ///
    /// A field is rough inside objects, where nothing was ever observed: the mean direction at four
    /// points around the surface is much smoother than the direction on it. 24 evaluations a ray.
    ///
    /// # Errors
    /// As [`density`](Self::density); [`Error::Range`] for a direction that goes nowhere,
    /// [`Error::InputLength`] unless there are as many depths as rays.
    pub fn surface_normals(
        &self,
        rays: &[Ray],
        depths: &[f32],
        scratch: &mut [f32],
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        let (needed, given) = (rays.len(), depths.len());
        if given != needed {
            return Err(Error::InputLength { needed, given });
        }
        check_output(needed, out.len())?;
        self.cut(scratch)?;
        for ray in rays {
            check_points(&[ray.origin])?;
        }
        if rays.iter().any(|ray| unit(ray.direction).is_none()) {
            return Err(DIRECTION);
        }
        let radius = RADIUS * self.gradient_step();
        let chunks = rays.chunks(RAYS).zip(depths.chunks(RAYS)).zip(out.chunks_mut(RAYS));
        for ((rays, depths), out) in chunks {
            let (mut points, mut slopes) = ([[0.0; 3]; 4 * RAYS], [[0.0; 3]; 4 * RAYS]);
            let mut n = 0;
            for (ray, t) in rays.iter().zip(depths).filter(|(_, t)| t.is_finite()) {
                let direction = unit(ray.direction).unwrap_or_default();
                for way in AROUND {
                    points[n] = from_fn(|a| ray.origin[a] + t * direction[a] + radius * way[a]);
                    n += 1;
                }
            }
            self.density_gradient(&points[..n], scratch, &mut slopes[..n])?;
            let mut slopes = slopes[..n].as_chunks::<4>().0.iter();
            for (out, t) in out.iter_mut().zip(depths) {
                let slopes = if t.is_finite() { slopes.next() } else { None };
                *out = slopes.map_or([0.0; 3], |slopes| {
                    let directions = slopes.map(normal);
                    // `normal` negates a slope.
                    normal(from_fn(|a| -directions.iter().map(|d| d[a]).sum::<f32>()))
                });
            }
        }
        Ok(())
    }
}
