//! Pictures with a deadline: coarse at once, finer as long as there is time and
//! the camera rests.

use std::borrow::Cow;
use std::time::{Duration, Instant};

use pocketnerf_core::render::{
    Refinement, Refinements, RenderStats, Tiles, average_tile, refine_tile,
};
use pocketnerf_core::{Camera, Error, Model, RenderOptions, Tile};

use super::{Picture, Settings};
use crate::pool::Pool;

/// Time to put tiles together, a ray: kept back from the deadline.
const ASSEMBLE: Duration = Duration::from_nanos(6);
/// Pixels of a level of detail, compared with those of the level before.
const GROWTH: u32 = 4;

/// A picture in refinement.
#[derive(Debug)]
pub struct Progressive<'m> {
    model: &'m Model<'m>,
    camera: Camera,
    /// Rays along a side of a pixel.
    n: u32,
    /// Sees a pixel for each ray.
    fine: Camera,
    options: RenderOptions,
    parts: Vec<Part>,
    scratch: Pool<Vec<f32>>,
}

/// A tile of the picture.
#[derive(Debug)]
struct Part {
    /// The rays' own.
    tile: Tile,
    rgba: Vec<f32>,
    /// Empty if depth is not rendered.
    depth: Vec<f32>,
    stats: RenderStats,
    /// Pixels from one that is rendered to the next; 0: none is yet.
    spacing: u32,
    /// What the last refinement took.
    took: Duration,
}

impl<'m> Progressive<'m> {
    /// The picture that `camera` takes, nothing of it rendered.
    #[must_use]
    pub fn new(model: &'m Model<'m>, camera: &Camera, settings: &Settings) -> Self {
        let n = settings.antialias.rays(camera);
        let fine = camera.finer(n);
        let tile = Tiles::supersampled(camera.width, camera.height, n).size();
        let coarsest = Refinements::new([fine.width, fine.height], tile.map(|side| side * n));
        let parts = coarsest.take_while(|piece| piece.known == 0).map(|piece| Part {
            tile: piece.tile,
            rgba: vec![0.0; piece.tile.pixels() * 4],
            depth: vec![0.0; if settings.depth { piece.tile.pixels() } else { 0 }],
            stats: RenderStats::default(),
            spacing: 0,
            took: Duration::ZERO,
        });
        let (parts, options) = (parts.collect(), settings.options(model));
        Self { model, camera: *camera, n, fine, options, parts, scratch: Pool::default() }
    }

    /// Refines until `deadline`, on all threads of the current pool; says whether
    /// the picture is finished. The coarsest level of detail is rendered in any
    /// case. A tile is left as it is if its next level would probably take too long.
    ///
    /// # Errors
    /// Whatever [`refine_tile`] reports.
    pub fn refine(&mut self, deadline: Instant) -> Result<bool, Error> {
        let pixels = self.fine.width.saturating_mul(self.fine.height);
        let deadline = deadline.checked_sub(ASSEMBLE * pixels).unwrap_or(deadline);
        let mut level = Refinements::COARSEST;
        while level > 0 {
            let (model, camera, options) = (self.model, &self.fine, &self.options);
            let coarser = |part: &&mut Part| part.spacing == 0 || part.spacing > level;
            let pending: Vec<&mut Part> = self.parts.iter_mut().filter(coarser).collect();
            let scratch = || vec![0.0; options.scratch_len()];
            self.scratch.map(pending, scratch, |scratch, part| {
                let begun = Instant::now();
                if part.spacing > 0 && begun + part.took * GROWTH > deadline {
                    return Ok(());
                }
                let piece = Refinement { tile: part.tile, known: part.spacing, spacing: level };
                let depth = (!part.depth.is_empty()).then_some(&mut part.depth[..]);
                let rgba = &mut part.rgba;
                part.stats += refine_tile(model, camera, &piece, options, scratch, rgba, depth)?;
                (part.spacing, part.took) = (level, begun.elapsed());
                Ok(())
            })?;
            level /= 2;
        }
        Ok(self.parts.iter().all(|part| part.spacing == 1))
    }

    /// The picture as it is now.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let (width, height) = (self.camera.width, self.camera.height);
        let (row, pixels) = (width as usize, width as usize * height as usize);
        let with_depth = self.parts.iter().any(|part| !part.depth.is_empty());
        let mut picture = Picture {
            width,
            height,
            rgba: vec![0.0; pixels * 4],
            depth: vec![0.0; if with_depth { pixels } else { 0 }],
            stats: RenderStats::default(),
        };
        for part in &self.parts {
            let (tile, rgba, depth) = part.pixels(self.n);
            let above = tile.y as usize * row;
            copy_rows(&rgba, &mut picture.rgba[4 * above..], 4, tile, row);
            if with_depth {
                copy_rows(&depth, &mut picture.depth[above..], 1, tile, row);
            }
            picture.stats += part.stats;
        }
        picture
    }

    /// The part of the picture's rays, one a pixel unless [`Settings::antialias`] says
    /// otherwise, in tiles of which at least every `spacing`-th along both axes is cast.
    #[must_use]
    pub fn share(&self, spacing: u32) -> f64 {
        let refined = |part: &&Part| (1..=spacing).contains(&part.spacing);
        let all: usize = self.parts.iter().map(|part| part.tile.pixels()).sum();
        let done: usize = self.parts.iter().filter(refined).map(|part| part.tile.pixels()).sum();
        done as f64 / all.max(1) as f64
    }
}

impl Part {
    /// The tile's pixels, of `n` × `n` rays each: colours and depths.
    fn pixels(&self, n: u32) -> (Tile, Cow<'_, [f32]>, Cow<'_, [f32]>) {
        let Tile { x, y, width, height } = self.tile;
        let tile = Tile { x: x / n, y: y / n, width: width / n, height: height / n };
        let (mut rgba, mut depth) = (Cow::from(&self.rgba), Cow::from(&self.depth));
        if n > 1 {
            let to = (!depth.is_empty()).then(|| &mut depth.to_mut()[..]);
            average_tile(tile, n, rgba.to_mut(), to).expect("as long as the tile");
        }
        (tile, rgba, depth)
    }
}

/// Copies a tile, `channels` values a pixel, to its columns of rows of `row` pixels.
fn copy_rows(from: &[f32], to: &mut [f32], channels: usize, tile: Tile, row: usize) {
    let n = tile.width as usize * channels;
    for (from, to) in from.chunks_exact(n).zip(to.chunks_exact_mut(row * channels)) {
        to[tile.x as usize * channels..][..n].copy_from_slice(from);
    }
}
