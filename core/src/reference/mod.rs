//! The oracle: a renderer that is slow and plain on purpose.
//!
//! It says what a model looks like, so that every faster renderer can be
//! compared with it. One point at a time, one weight at a time
//! ([`TensorView::get`](crate::TensorView::get)), in f64, sharing no kernel with
//! the fast path. A ray tries *every* sample of its grid, from the first to the
//! last, and tests the box and the occupancy grid at each.
//!
//! Volume rendering is equation 3 of the NeRF paper (Mildenhall et al. 2020)
//! with a constant step δ. For the samples k inside box and occupancy, front to
//! back:
//!
//! ```text
//! t_k = near + (k + 0.5) δ                     scene units
//! σ_k = exp(min(raw_k + log_density_bias, 15)) 1 / scene unit
//! α_k = 1 − exp(−σ_k δ)
//! w_k = T_k α_k,   T_1 = 1,   T_(k+1) = T_k (1 − α_k)
//! W = Σ w_k,   depth = Σ w_k t_k / W
//! rgb = opacity · Σ w_k c_k / W                      shading per sample
//! rgb = opacity · shade(Σ w_k f_k / W, d)            shading per ray
//! ```
//!
//! Where the space is no box, the ray is the one in its own coordinates, straight or of
//! straight pieces, and t, δ and σ are in their units; the depth is turned back into scene units at the end.
//!
//! The sum ends after the sample that takes T below `min_transmittance`; the ray
//! then counts as opaque: opacity is 1, else W.
//!
//! Two things are f32 on purpose, because renderers must agree on them before
//! they can be compared: where a sample lies (`t`, then `origin + t * direction`,
//! then its unit coordinates, each a plain multiplication and addition), and so
//! on which side of a wall it falls.
//!
//! Models need not have been verified: a NaN log density is empty space and a
//! NaN colour is black, so no result ever holds NaN, and every ray ends.

#[cfg_attr(not(feature = "contracted"), path = "no_contracted.rs")]
mod contracted;
pub(crate) mod field;
pub(crate) mod harmonics;
mod hierarchical;
pub(crate) mod math;
pub(crate) mod network;
mod ray;
mod space;
#[cfg(test)]
pub(crate) mod testing;

pub use network::MAX_WIDTH;
pub use ray::RayResult;

use crate::field::ReferenceField;
use crate::march::Hierarchical;
use crate::{Camera, Error, Model, Ray};

/// What the field says of one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointResult {
    /// Density per unit of the space's own coordinates, of a box 1 / scene unit. 0
    /// outside and in cells that are not occupied.
    pub sigma: f32,
    /// Colour of this point alone, straight (not premultiplied), in the model's
    /// colour space. A field that is shaded per ray is evaluated as if its ray held
    /// nothing but this point. Black where the field is not evaluated.
    pub rgb: [f32; 3],
}

/// Density and colour of scene point `point`, seen along the unit vector `direction`.
///
/// # Errors
/// Whatever [`Model::validate`] reports; [`Error::Limits`] for a network wider
/// than [`MAX_WIDTH`].
pub fn query(
    model: &Model<'_>,
    point: [f32; 3],
    direction: [f32; 3],
) -> Result<PointResult, Error> {
    let (sigma, rgb) = query_f64(model, point, direction)?;
    Ok(PointResult { sigma: sigma as f32, rgb: rgb.map(|c| c as f32) })
}

/// The density and colour of [`query`] as they were computed, not rounded to `f32`: for
/// differences of two that are close.
///
/// # Errors
/// As [`query`].
pub fn query_f64(
    model: &Model<'_>,
    point: [f32; 3],
    direction: [f32; 3],
) -> Result<(f64, [f64; 3]), Error> {
    field::check(model)?;
    let place = |p| field::place(model, p);
    let Some(u) = space::point(&model.space, point).and_then(place) else {
        return Ok((0.0, [0.0; 3]));
    };
    let (sigma, channels) = model.field.reference(u, direction);
    let rgb = match model.field.deferred() {
        Some(decoder) => field::shade(decoder, &channels, direction),
        None => [channels[0], channels[1], channels[2]],
    };
    Ok((sigma, rgb))
}

/// Renders one ray.
///
/// # Errors
/// As [`query`].
pub fn render_ray(model: &Model<'_>, ray: &Ray) -> Result<RayResult, Error> {
    field::check(model)?;
    Ok(ray::march(model, ray))
}

/// Renders one ray by [`Hierarchical`] samples. `axis` is where the camera
/// that it comes from looks, if there is one.
///
/// # Errors
/// As [`query`].
pub fn render_ray_hierarchically(
    model: &Model<'_>,
    ray: &Ray,
    axis: Option<[f32; 3]>,
    hierarchical: &Hierarchical,
) -> Result<RayResult, Error> {
    field::check(model)?;
    hierarchical.validate()?;
    Ok(hierarchical::march(model, ray, axis, hierarchical))
}

/// Renders the ray through the centre of pixel (`x`, `y`): `camera.ray(x + 0.5, y + 0.5)`.
///
/// # Errors
/// As [`query`].
pub fn render_pixel(
    model: &Model<'_>,
    camera: &Camera,
    x: u32,
    y: u32,
) -> Result<RayResult, Error> {
    let mut out = [RayResult::EMPTY];
    render_tile(model, camera, [x, y], [1, 1], &mut out)?;
    Ok(out[0])
}

/// Renders the pixels from `corner` (x, y) on, `size` (width, height) of them,
/// row after row into `out`, which holds exactly width × height results.
///
/// The tile need not lie within the picture: the image plane goes on beyond it.
///
/// # Errors
/// As [`query`]; [`Error::OutputLength`].
pub fn render_tile(
    model: &Model<'_>,
    camera: &Camera,
    corner: [u32; 2],
    size: [u32; 2],
    out: &mut [RayResult],
) -> Result<(), Error> {
    field::check(model)?;
    let needed = (size[0] as usize).saturating_mul(size[1] as usize);
    if out.len() != needed {
        return Err(Error::OutputLength { needed, given: out.len() });
    }
    for (i, pixel) in out.iter_mut().enumerate() {
        let (column, row) = (i % size[0] as usize, i / size[0] as usize);
        let x = (f64::from(corner[0]) + column as f64 + 0.5) as f32;
        let y = (f64::from(corner[1]) + row as f64 + 0.5) as f32;
        *pixel = ray::march(model, &camera.ray(x, y));
    }
    Ok(())
}

/// Renders the camera's whole picture, row after row into `out`, which holds
/// exactly `camera.width * camera.height` results.
///
/// # Errors
/// As [`render_tile`].
pub fn render_picture(
    model: &Model<'_>,
    camera: &Camera,
    out: &mut [RayResult],
) -> Result<(), Error> {
    render_tile(model, camera, [0, 0], [camera.width, camera.height], out)
}

#[cfg(test)]
mod tests;
