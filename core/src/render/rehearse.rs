//! What interpolation would make of a picture, tried on the finest of it.

use crate::Error;
use crate::render::foreground::Foreground;
use crate::render::passes::Span;
use crate::render::target::Target;
use crate::render::{Detail, RenderStats};

/// Makes of a tile's `finest` pixels what [`render_tile`](crate::render_tile) would
/// make with these tolerances, and counts the rays that it would cast; nothing
/// else of `detail` matters. Both slices hold premultiplied RGBA, four values a
/// pixel, row after row. No ray is cast: tolerances are chosen this way.
///
/// # Errors
/// [`Error::OutputLength`] where a slice is too short, [`Error::Range`] where
/// `detail` cannot be rendered with.
pub fn rehearse_tile(
    [width, height]: [u32; 2],
    detail: &Detail,
    finest: &[f32],
    rgba: &mut [f32],
) -> Result<RenderStats, Error> {
    detail.validate()?;
    let needed = (width as usize).saturating_mul(height as usize).saturating_mul(4);
    let given = finest.len().min(rgba.len());
    if given < needed {
        return Err(Error::OutputLength { needed, given });
    }
    let finest = finest.as_chunks::<4>().0;
    let rgba = rgba.as_chunks_mut().0;
    let foreground = Foreground::unknown(&mut []);
    let size = [width, height];
    let mut target = Target { rgba, depth: None, size, cell: 0.0, foreground };
    let mut stats = RenderStats::default();
    for pass in Span::all(detail.spacing()).passes([width, height]) {
        let tolerance = detail.tolerance(pass.half());
        for [x, y] in pass.pixels() {
            if pass.half() == 0 || !target.interpolate(pass, [x, y], tolerance) {
                let pixel = y as usize * width as usize + x as usize;
                target.rgba[pixel] = finest[pixel];
                stats.rays += 1;
            }
        }
    }
    Ok(stats)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_neighbours_agree_on_is_interpolated() {
        // An opaque ramp along x, with one pixel that is unlike the others.
        let mut finest = [0.0; 9 * 9 * 4];
        for (i, pixel) in finest.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            *pixel = [(i % 9) as f32 / 64.0, 0.5, 0.5, 1.0];
        }
        finest[(4 * 9 + 4) * 4] = 0.3;
        let rehearse = |tolerance: f32| {
            let detail = Detail { tolerances: [tolerance, 0.0, 0.0, 0.0], ..Detail::FINEST };
            let mut rgba = [0.0; 9 * 9 * 4];
            let stats = rehearse_tile([9, 9], &detail, &finest, &mut rgba).unwrap();
            let wrong = rgba.iter().zip(finest).filter(|(a, b)| (*a - b).abs() > 1e-6).count();
            (stats.rays, wrong)
        };
        assert_eq!(rehearse(0.0), (81, 0));
        // The odd one lies on the grid of every second pixel: the four squares around
        // it, and the four sides that it ends, are looked at. Sides of the border have
        // three neighbours.
        assert_eq!(rehearse(0.05), (25 + 4 + 4 + 16, 0));
        // Now nothing is looked at but the border and the grid.
        let (rays, wrong) = rehearse(0.5);
        assert_eq!(rays, 25 + 16);
        assert!(wrong >= 8);
    }
}
