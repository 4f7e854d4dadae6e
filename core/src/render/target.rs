//! The pixels of a tile: where pictures are written, and read again where a
//! pixel is the mean of others.

use crate::render::passes::Pass;

/// The caller's buffers.
pub(super) struct Target<'p> {
    /// Premultiplied, a pixel each.
    pub(super) rgba: &'p mut [[f32; 4]],
    /// Expected distance, infinite where nothing is.
    pub(super) depth: Option<&'p mut [f32]>,
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    /// Pixels that the narrowest occupied cell is wide.
    pub(super) cell: f32,
}

impl Target<'_> {
    /// Writes a pixel whose ray meets nothing.
    #[inline(always)]
    pub(super) fn clear(&mut self, pixel: u32) {
        self.rgba[pixel as usize] = [0.0; 4];
        if let Some(depth) = &mut self.depth {
            depth[pixel as usize] = f32::INFINITY;
        }
    }

    /// Writes the mean of a pixel's neighbours, if they differ by less than
    /// `tolerance`, and says whether. Where they see next to nothing, a thin
    /// thing may run between them: the pixel is empty only if all of them miss
    /// every occupied cell, and none can hide between them.
    pub(super) fn interpolate(&mut self, pass: Pass, [x, y]: [u32; 2], tolerance: f32) -> bool {
        let mut around = Around::NONE;
        pass.neighbours([x, y], |pair, [x, y]| {
            around.add(pair, self.rgba[(y * self.size[0] + x) as usize]);
        });
        if !around.agree(tolerance) {
            return false;
        }
        let pixel = (y * self.size[0] + x) as usize;
        if around.most[3] < tolerance {
            let certain = around.most[3] == 0.0 && self.cell >= 2.5 * pass.half() as f32;
            if certain {
                self.clear(pixel as u32);
            }
            return certain;
        }
        if self.depth.is_some() {
            let Some(depth) = self.mean_depth(pass, [x, y], tolerance) else { return false };
            if let Some(depths) = &mut self.depth {
                depths[pixel] = depth;
            }
        }
        self.rgba[pixel] = around.mean();
        true
    }

    /// Fills the pixels between those of the grid of this spacing: bilinear.
    pub(super) fn fill(&mut self, spacing: u32) {
        let [width, height] = self.size;
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
            let (mut rgba, mut depth) = ([0.0; 4], [0.0; 2]);
            for (row, v) in between(y, height) {
                for (column, u) in between(x, width) {
                    let from = (row * width + column) as usize;
                    let (weight, theirs) = (u * v, self.rgba[from]);
                    for (sum, value) in rgba.iter_mut().zip(theirs) {
                        *sum += weight * value;
                    }
                    if let Some(depths) = self.depth.as_ref().filter(|_| weight * theirs[3] > 0.0) {
                        depth[0] += weight * theirs[3] * depths[from];
                        depth[1] += weight * theirs[3];
                    }
                }
            }
            let pixel = (y * width + x) as usize;
            self.rgba[pixel] = rgba;
            if let Some(depths) = &mut self.depth {
                depths[pixel] = if depth[1] > 0.0 { depth[0] / depth[1] } else { f32::INFINITY };
            }
        }
    }

    /// The mean depth of a pixel's neighbours, weighted by opacity, if they
    /// differ by less than this part of it.
    fn mean_depth(&self, pass: Pass, pixel: [u32; 2], tolerance: f32) -> Option<f32> {
        let depths = self.depth.as_ref()?;
        let (mut weight, mut sum, mut least, mut most) = (0.0, 0.0, f32::INFINITY, 0.0f32);
        pass.neighbours(pixel, |_, [x, y]| {
            let i = (y * self.size[0] + x) as usize;
            let (alpha, depth) = (self.rgba[i][3], depths[i]);
            if alpha > 0.0 {
                weight += alpha;
                sum += alpha * depth;
                least = least.min(depth);
                most = most.max(depth);
            }
        });
        (most - least <= tolerance * least).then_some(sum / weight)
    }
}

/// What the neighbours of a pixel have in common.
struct Around {
    /// Neighbours of both pairs.
    n: [f32; 2],
    /// Their sums.
    sums: [[f32; 4]; 2],
    least: [f32; 4],
    most: [f32; 4],
}

impl Around {
    const NONE: Self = Self {
        n: [0.0; 2],
        sums: [[0.0; 4]; 2],
        least: [f32::INFINITY; 4],
        most: [f32::NEG_INFINITY; 4],
    };

    #[inline(always)]
    fn add(&mut self, pair: usize, rgba: [f32; 4]) {
        self.n[pair] += 1.0;
        for (c, value) in rgba.into_iter().enumerate() {
            self.sums[pair][c] += value;
            self.least[c] = self.least[c].min(value);
            self.most[c] = self.most[c].max(value);
        }
    }

    #[inline(always)]
    fn mean(&self) -> [f32; 4] {
        let [a, b] = self.sums;
        core::array::from_fn(|c| (a[c] + b[c]) / (self.n[0] + self.n[1]))
    }

    /// Whether there are four neighbours that differ by less than the tolerance,
    /// and the means of the two pairs by less than a third of it: slopes are
    /// interpolated well, bends are not, and two neighbours agree by chance.
    #[inline(always)]
    fn agree(&self, tolerance: f32) -> bool {
        let [a, b] = self.sums;
        self.n == [2.0; 2]
            && (0..4).all(|c| {
                let bend = 0.5 * (a[c] - b[c]).abs();
                (self.most[c] - self.least[c]).max(3.0 * bend) < tolerance
            })
    }
}
