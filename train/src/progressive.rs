//! Pictures with a deadline: coarse at once, finer as long as there is time and
//! the camera rests.

use std::time::{Duration, Instant};

use pocketnerf_core::render::{Refinement, Refinements, refine_tile};
use pocketnerf_core::{Camera, Error, Model, RenderOptions};
use rayon::prelude::*;

use crate::picture::{Part, Picture, Settings, TILE};

/// Time to put tiles together, a pixel: kept back from the deadline.
const ASSEMBLE: Duration = Duration::from_nanos(6);
/// Pixels of a level of detail, compared with those of the level before.
const GROWTH: u32 = 4;

/// A picture in refinement.
#[derive(Debug)]
pub struct Progressive<'m> {
    model: &'m Model<'m>,
    camera: Camera,
    options: RenderOptions,
    tiles: Vec<Tile>,
}

#[derive(Debug)]
struct Tile {
    part: Part,
    /// Every so manieth pixel is rendered; 0: none yet.
    spacing: u32,
    /// What the last refinement took.
    took: Duration,
}

impl<'m> Progressive<'m> {
    /// The picture that `camera` takes, nothing of it rendered.
    #[must_use]
    pub fn new(model: &'m Model<'m>, camera: &Camera, settings: &Settings) -> Self {
        let coarsest = Refinements::new(camera.width, camera.height, TILE);
        let tiles = coarsest.take_while(|piece| piece.known == 0).map(|piece| Tile {
            part: Part::new(piece.tile, settings.depth),
            spacing: 0,
            took: Duration::ZERO,
        });
        let (tiles, options) = (tiles.collect(), settings.options(model));
        Self { model, camera: *camera, options, tiles }
    }

    /// Refines until `deadline`, on all threads of the current pool; says whether
    /// the picture is finished. The coarsest level of detail is rendered in any
    /// case. A tile is left as it is if its next level would probably take too long.
    ///
    /// # Errors
    /// Whatever [`refine_tile`] reports.
    pub fn refine(&mut self, deadline: Instant) -> Result<bool, Error> {
        let pixels = self.camera.width.saturating_mul(self.camera.height);
        let deadline = deadline.checked_sub(ASSEMBLE * pixels).unwrap_or(deadline);
        let mut level = Refinements::COARSEST;
        while level > 0 {
            let (model, camera, options) = (self.model, &self.camera, &self.options);
            let coarser = |tile: &&mut Tile| tile.spacing == 0 || tile.spacing > level;
            let pending: Vec<&mut Tile> = self.tiles.iter_mut().filter(coarser).collect();
            pending.into_par_iter().try_for_each_init(
                || vec![0.0; options.scratch_len()],
                |scratch, tile| {
                    let begun = Instant::now();
                    if tile.spacing > 0 && begun + tile.took * GROWTH > deadline {
                        return Ok(());
                    }
                    let piece =
                        Refinement { tile: tile.part.tile, known: tile.spacing, spacing: level };
                    let (rgba, depth) = tile.part.buffers();
                    let stats = refine_tile(model, camera, &piece, options, scratch, rgba, depth)?;
                    tile.part.stats += stats;
                    (tile.spacing, tile.took) = (level, begun.elapsed());
                    Ok(())
                },
            )?;
            level /= 2;
        }
        Ok(self.tiles.iter().all(|tile| tile.spacing == 1))
    }

    /// The picture as it is now.
    #[must_use]
    pub fn picture(&self) -> Picture {
        Picture::assemble(&self.camera, self.tiles.iter().map(|tile| &tile.part))
    }

    /// The part of the picture's pixels, in tiles of which at least every
    /// `spacing`-th pixel along both axes is rendered.
    #[must_use]
    pub fn share(&self, spacing: u32) -> f64 {
        let pixels = |tile: &Tile| tile.part.tile.pixels();
        let refined = |tile: &&Tile| (1..=spacing).contains(&tile.spacing);
        let all: usize = self.tiles.iter().map(pixels).sum();
        let done: usize = self.tiles.iter().filter(refined).map(pixels).sum();
        done as f64 / all.max(1) as f64
    }
}
