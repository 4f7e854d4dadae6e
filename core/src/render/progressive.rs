//! A picture that is there at once and becomes finer as long as there is time.

use crate::render::driver::{self, Job};
use crate::render::passes::Span;
use crate::render::source::Pixels;
use crate::render::{RenderOptions, RenderStats, Tile};
use crate::{Camera, Error, Model};

/// A piece of work: one tile, one level of detail finer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refinement {
    /// Which pixels.
    pub tile: Tile,
    /// Pixels from one that is rendered already to the next, along both axes;
    /// 0: none is.
    pub known: u32,
    /// The same afterwards; the pixels between are interpolated.
    pub spacing: u32,
}

/// All pieces of work for a picture, coarse to fine; within a level of detail,
/// tile by tile. Work can stop anywhere when time runs out: the tiles that were
/// refined stay so. Tiles are independent of one another, so that those of a
/// level may be handed to several threads.
///
/// ```
/// use pocketnerf_core::Tile;
/// use pocketnerf_core::render::Refinements;
///
/// let work: Vec<_> = Refinements::new([32, 16], [16, 16]).collect();
/// // Two tiles at five levels: every 16th, 8th, 4th, 2nd and every pixel.
/// assert_eq!(work.len(), 10);
/// assert_eq!((work[1].known, work[1].spacing), (0, 16));
/// assert_eq!((work[9].known, work[9].spacing), (2, 1));
/// assert_eq!(work[9].tile, Tile { x: 16, y: 0, width: 16, height: 16 });
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Refinements {
    size: [u32; 2],
    tile: [u32; 2],
    /// The next tile's corner.
    at: [u32; 2],
    known: u32,
    spacing: u32,
}

impl Refinements {
    /// Spacing of the coarsest level, pixels.
    pub const COARSEST: u32 = 16;

    /// For a picture of this width and height, in tiles of that (at least 1).
    #[must_use]
    pub const fn new(size: [u32; 2], [width, height]: [u32; 2]) -> Self {
        let tile = [if width == 0 { 1 } else { width }, if height == 0 { 1 } else { height }];
        Self { size, tile, at: [0, 0], known: 0, spacing: Self::COARSEST }
    }
}

impl Iterator for Refinements {
    type Item = Refinement;

    fn next(&mut self) -> Option<Refinement> {
        let [width, height] = self.size;
        if self.spacing == 0 || width == 0 || height == 0 {
            return None;
        }
        let ([x, y], [w, h]) = (self.at, self.tile);
        let tile = Tile { x, y, width: w.min(width - x), height: h.min(height - y) };
        let refinement = Refinement { tile, known: self.known, spacing: self.spacing };
        self.at[0] = x.saturating_add(w);
        if self.at[0] >= width {
            self.at = [0, y.saturating_add(h)];
        }
        if self.at[1] >= height {
            *self = Self { at: [0, 0], known: self.spacing, spacing: self.spacing / 2, ..*self };
        }
        Some(refinement)
    }
}

/// Renders what is new in a refinement of the picture that `camera` takes.
///
/// `rgba` and `depth` are the tile's own, as for
/// [`render_tile`](crate::render_tile), and hold what the refinement before it
/// has left there. After the last one they hold the pixels of `render_tile`.
///
/// # Errors
/// As `render_tile`, and for spacings that are no powers of two, or not finer
/// than what is known.
pub fn refine_tile(
    model: &Model<'_>,
    camera: &Camera,
    refinement: &Refinement,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    mut depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    let Refinement { tile, known, spacing } = *refinement;
    let sound = spacing.is_power_of_two()
        && spacing <= 1 << 16
        && (known == 0 || (known.is_power_of_two() && spacing < known && known <= 1 << 16));
    if !sound {
        return Err(Error::Range("refinement: spacing and what is known"));
    }
    let (source, span) = (&Pixels { camera, tile }, Span { known, grid: spacing, to: spacing });
    let job = Job { model, source, options, span };
    let stats = driver::render(&job, scratch, rgba, depth.as_deref_mut(), None)?;
    fill([tile.width, tile.height], spacing, rgba.as_chunks_mut().0, depth);
    Ok(stats)
}

/// Fills the pixels between those of the grid of this spacing: bilinear.
fn fill(
    [width, height]: [u32; 2],
    spacing: u32,
    rgba: &mut [[f32; 4]],
    mut depth: Option<&mut [f32]>,
) {
    if spacing == 1 {
        return;
    }
    let is_known = |c: u32, n: u32| c.is_multiple_of(spacing) || c + 1 == n;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    for [x, y] in pixels.filter(|[x, y]| !is_known(*x, width) || !is_known(*y, height)) {
        let between = |c: u32, n: u32| {
            let low = c - c % spacing;
            let high = (low + spacing).min(n - 1);
            let part = (c - low) as f32 / high.abs_diff(low).max(1) as f32;
            [(low, 1.0 - part), (high, part)]
        };
        let (mut color, mut sums) = ([0.0; 4], [0.0; 2]);
        for (row, v) in between(y, height) {
            for (column, u) in between(x, width) {
                let from = (row * width + column) as usize;
                let (weight, theirs) = (u * v, rgba[from]);
                for (sum, value) in color.iter_mut().zip(theirs) {
                    *sum += weight * value;
                }
                if let Some(depths) = depth.as_ref().filter(|_| weight * theirs[3] > 0.0) {
                    sums[0] += weight * theirs[3] * depths[from];
                    sums[1] += weight * theirs[3];
                }
            }
        }
        let pixel = (y * width + x) as usize;
        rgba[pixel] = color;
        if let Some(depths) = &mut depth {
            depths[pixel] = if sums[1] > 0.0 { sums[0] / sums[1] } else { f32::INFINITY };
        }
    }
}
