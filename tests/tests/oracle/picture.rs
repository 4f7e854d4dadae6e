//! Pictures by the renderer under test.

use pocketnerf_core::render::{Detail, RenderStats, render_rays};
use pocketnerf_core::render_tile;
use pocketnerf_core::{Camera, Error, Model, Ray, RenderOptions, SimdLevel, Tile, Tuning};

/// The levels that this machine has.
pub(crate) fn levels() -> impl Iterator<Item = SimdLevel> {
    SimdLevel::ALL.into_iter().filter(|level| level.is_available())
}

#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub rgba: Vec<[f32; 4]>,
    pub depth: Vec<f32>,
    pub stats: RenderStats,
}

impl Picture {
    /// Asserts that every bit is the same.
    #[track_caller]
    pub(crate) fn assert_same(&self, other: &Self, what: &str) {
        for (i, (a, b)) in self.rgba.iter().zip(&other.rgba).enumerate() {
            assert_eq!(a.map(f32::to_bits), b.map(f32::to_bits), "{what}: pixel {i}: {a:?}, {b:?}");
        }
        for (i, (a, b)) in self.depth.iter().zip(&other.depth).enumerate() {
            assert_eq!(a.to_bits(), b.to_bits(), "{what}: depth {i}: {a}, {b}");
        }
        assert_eq!(self.rgba.len(), other.rgba.len(), "{what}");
        assert_eq!(self.stats, other.stats, "{what}");
    }
}

/// What the scratch holds before a call: it must not matter.
pub(crate) const GARBAGE: f32 = f32::NAN;

/// Renders with scratch of exactly the promised length, full of [`GARBAGE`].
pub(crate) fn tile(
    model: &Model<'_>,
    camera: &Camera,
    tile: Tile,
    options: &RenderOptions,
) -> Picture {
    picture(tile.pixels(), options, |scratch, rgba, depth| {
        render_tile(model, camera, tile, options, scratch, rgba, Some(depth))
    })
}

/// As [`tile`], for any rays.
pub(crate) fn rays(model: &Model<'_>, rays: &[Ray], options: &RenderOptions) -> Picture {
    picture(rays.len(), options, |scratch, rgba, depth| {
        render_rays(model, rays, options, scratch, rgba, Some(depth))
    })
}

fn picture(
    n: usize,
    options: &RenderOptions,
    render: impl FnOnce(&mut [f32], &mut [f32], &mut [f32]) -> Result<RenderStats, Error>,
) -> Picture {
    let mut scratch = vec![GARBAGE; options.scratch_len()];
    let (mut rgba, mut depth) = (vec![[GARBAGE; 4]; n], vec![GARBAGE; n]);
    let stats = render(&mut scratch, rgba.as_flattened_mut(), &mut depth).unwrap();
    Picture { rgba, depth, stats }
}

/// All of the camera's picture.
pub(crate) fn whole(camera: &Camera) -> Tile {
    Tile { x: 0, y: 0, width: camera.width, height: camera.height }
}

/// The usual options, and every pixel.
pub(crate) fn options(model: &Model<'_>, level: SimdLevel, tuning: Tuning) -> RenderOptions {
    RenderOptions { detail: Detail::FINEST, ..RenderOptions::new(model, level, tuning) }
}
