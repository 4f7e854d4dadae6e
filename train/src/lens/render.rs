//! Tiles of pictures that a lens takes.

use pocketnerf_core::render::{RenderStats, render_rays};
use pocketnerf_core::{Camera, Error, Model, Ray, RenderOptions, Tile, render_tile};

use super::Lens;

/// [`render_tile`] through a lens: where it bends rays, pixels are rendered one by one,
/// and none is interpolated.
pub(crate) fn render_through(
    model: &Model<'_>,
    (camera, lens): (&Camera, &Lens),
    tile: Tile,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    if *lens == Lens::Pinhole {
        return render_tile(model, camera, tile, options, scratch, rgba, depth);
    }
    let Tile { x, y, width, height } = tile;
    let pixels = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y)));
    let ray = |(x, y)| lens.ray(camera, x as f32 + 0.5, y as f32 + 0.5);
    let rays: Vec<Ray> = pixels.map(ray).collect();
    render_rays(model, &rays, options, scratch, rgba, depth)
}
