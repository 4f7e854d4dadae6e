//! The pixels of a tile: where pictures are written, and read again where a
//! pixel is the mean of others.

use crate::render::foreground::Foreground;
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
    /// Where anything may be.
    pub(super) foreground: Foreground<'p>,
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
        let Some(around) = pass.neighbours([x, y]) else { return false };
        let [a, b, c, d] = around.map(|[x, y]| (y * self.size[0] + x) as usize);
        let colors = [self.rgba[a], self.rgba[b], self.rgba[c], self.rgba[d]];
        if !agree(&colors, tolerance) {
            return false;
        }
        let pixel = (y * self.size[0] + x) as usize;
        let opacity = colors.iter().fold(0.0, |most, color| color[3].max(most));
        if opacity < tolerance {
            let certain = opacity == 0.0 && self.cell >= 2.5 * pass.half() as f32;
            if certain {
                self.clear(pixel as u32);
            }
            return certain;
        }
        if let Some(depths) = &mut self.depth {
            let theirs = [depths[a], depths[b], depths[c], depths[d]];
            let Some(depth) = mean_depth(&colors, &theirs, tolerance) else { return false };
            depths[pixel] = depth;
        }
        let [a, b, c, d] = colors;
        for (to, i) in self.rgba[pixel].iter_mut().zip(0..) {
            *to = ((a[i] + b[i]) + (c[i] + d[i])) / 4.0;
        }
        true
    }
}

/// Whether four pixels differ by less than the tolerance, and the means of the first
/// and the last two by less than a third of it: slopes are interpolated well, bends
/// are not.
#[inline(always)]
fn agree([a, b, c, d]: &[[f32; 4]; 4], tolerance: f32) -> bool {
    (0..4).all(|i| {
        let least = a[i].min(b[i]).min(c[i].min(d[i]));
        let most = a[i].max(b[i]).max(c[i].max(d[i]));
        let bend = 0.5 * ((a[i] + b[i]) - (c[i] + d[i])).abs();
        (most - least).max(3.0 * bend) < tolerance
    })
}

/// The mean depth of a pixel's neighbours, weighted by opacity, if those that see
/// anything differ by less than this part of it.
fn mean_depth(colors: &[[f32; 4]; 4], depths: &[f32; 4], tolerance: f32) -> Option<f32> {
    let (mut weight, mut sum, mut least, mut most) = (0.0, 0.0, f32::INFINITY, 0.0f32);
    for ([.., alpha], depth) in colors.iter().zip(depths) {
        if *alpha > 0.0 {
            weight += alpha;
            sum += alpha * depth;
            least = least.min(*depth);
            most = most.max(*depth);
        }
    }
    (most - least <= tolerance * least).then_some(sum / weight)
}
