//! Several rays a pixel: from a tile's finer pixels to its own.

use crate::Error;
use crate::render::Tile;

/// Makes pixels of `n` × `n` finer ones, in place: the mean of what is seen in them, where a
/// ray through a pixel's centre sees one point.
///
/// `rgba` and `depth` hold what [`render_tile`](crate::render_tile) writes for
/// [`tile.finer(n)`](Tile::finer) and [`camera.finer(n)`](crate::Camera::finer); afterwards
/// their first pixels are those of `tile`, row after row, and the rest holds anything. Colours
/// are premultiplied, so what is transparent has no colour in the mean. Depth is the mean of the
/// distances that are finite, each weighted by its opacity: what a pixel's light has come from;
/// infinite where nothing is. One ray a pixel changes nothing.
///
/// # Errors
/// [`Error::Range`] for an `n` of 0, [`Error::OutputLength`] where a slice is shorter than the
/// finer tile.
///
/// ```
/// use pocketnerf_core::render::average_tile;
/// use pocketnerf_core::Tile;
///
/// // A pixel whose left half is red, and half opaque.
/// let (red, nothing) = ([0.5, 0.0, 0.0, 0.5], [0.0; 4]);
/// let mut rgba = [red, nothing, red, nothing].concat();
/// let mut depth = [3.0, f32::INFINITY, 5.0, f32::INFINITY];
/// let tile = Tile { x: 7, y: 0, width: 1, height: 1 };
/// average_tile(tile, 2, &mut rgba, Some(&mut depth))?;
/// assert_eq!(rgba[..4], [0.25, 0.0, 0.0, 0.25]);
/// assert_eq!(depth[0], 4.0);
/// # Ok::<(), pocketnerf_core::Error>(())
/// ```
pub fn average_tile(
    tile: Tile,
    n: u32,
    rgba: &mut [f32],
    mut depth: Option<&mut [f32]>,
) -> Result<(), Error> {
    if n == 0 {
        return Err(Error::Range("rays along a side of a pixel, expected at least 1"));
    }
    let pixels = tile.finer(n).pixels();
    let depth_len = depth.as_ref().map_or(usize::MAX, |depth| depth.len());
    for (needed, given) in [(pixels.saturating_mul(4), rgba.len()), (pixels, depth_len)] {
        if given < needed {
            return Err(Error::OutputLength { needed, given });
        }
    }
    if n == 1 {
        return Ok(());
    }
    let rgba = rgba.as_chunks_mut::<4>().0;
    let (width, n) = (tile.width as usize, n as usize);
    let rays = (n * n) as f32;
    for y in 0..tile.height as usize {
        for x in 0..width {
            let (mut sum, mut distance, mut opacity) = ([0.0; 4], 0.0, 0.0);
            for row in 0..n {
                let first = ((y * n + row) * width + x) * n;
                for at in first..first + n {
                    let pixel = rgba[at];
                    sum.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += value);
                    let known = depth.as_ref().map(|depth| depth[at]).filter(|d| d.is_finite());
                    if let Some(known) = known {
                        distance += pixel[3] * known;
                        opacity += pixel[3];
                    }
                }
            }
            // No pixel to come is read from before this place.
            let to = y * width + x;
            rgba[to] = sum.map(|sum| sum / rays);
            if let Some(depth) = &mut depth {
                depth[to] = if opacity > 0.0 { distance / opacity } else { f32::INFINITY };
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const TILE: Tile = Tile { x: 5, y: 9, width: 3, height: 2 };

    /// Whole numbers, whose sums are exact: red is the finer pixel's column, green its row.
    fn finer(n: u32) -> Vec<f32> {
        let Tile { width, height, .. } = TILE.finer(n);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x as f32, y as f32]));
        pixels.flat_map(|[x, y]| [x, y, 2.0, 1.0]).collect()
    }

    #[test]
    fn every_pixel_is_the_mean_of_its_own() {
        for n in 1..5 {
            let mut rgba = finer(n);
            let mut depth: Vec<f32> = rgba.iter().step_by(4).map(|x| x + 10.0).collect();
            average_tile(TILE, n, &mut rgba, Some(&mut depth)).unwrap();
            for (i, (pixel, depth)) in rgba.as_chunks::<4>().0.iter().zip(depth).take(6).enumerate()
            {
                // The middle of n whole numbers.
                let mean = |at: usize| (at as u32 * n) as f32 + 0.5 * (n - 1) as f32;
                assert_eq!(*pixel, [mean(i % 3), mean(i / 3), 2.0, 1.0], "{n} {i}");
                assert_eq!(depth, mean(i % 3) + 10.0, "{n} {i}");
            }
        }
    }

    #[test]
    fn depth_is_where_the_light_has_come_from() {
        let tile = Tile { width: 1, height: 1, ..TILE };
        let depth_of = |alphas: [f32; 4], mut depth: [f32; 4]| {
            let mut rgba = alphas.map(|alpha| [0.0, 0.0, 0.0, alpha]);
            average_tile(tile, 2, rgba.as_flattened_mut(), Some(&mut depth)).unwrap();
            depth[0]
        };
        let none = f32::INFINITY;
        // (0.75 * 2 + 0.25 * 6) / (0.75 + 0.25) = 3.
        assert_eq!(depth_of([0.75, 0.0, 0.25, 0.0], [2.0, none, 6.0, none]), 3.0);
        assert_eq!(depth_of([1.0, 1.0, 0.0, 0.0], [2.0, none, 9.0, f32::NAN]), 2.0);
        assert_eq!(depth_of([0.0; 4], [none; 4]), none);
    }

    #[test]
    fn one_ray_changes_nothing_and_what_does_not_fit_is_refused() {
        let mut rgba = finer(1);
        rgba[3] = -0.0;
        let before = rgba.clone();
        average_tile(TILE, 1, &mut rgba, None).unwrap();
        assert!(rgba.iter().zip(&before).all(|(a, b)| a.to_bits() == b.to_bits()));
        let mut average = |n, len: usize, depth_len: usize| {
            let mut depth = std::vec![0.0; depth_len];
            average_tile(TILE, n, &mut rgba[..len], Some(&mut depth))
        };
        assert!(matches!(average(0, 24, 6), Err(Error::Range(_))));
        assert_eq!(average(1, 23, 6), Err(Error::OutputLength { needed: 24, given: 23 }));
        assert_eq!(average(2, 24, 24), Err(Error::OutputLength { needed: 96, given: 24 }));
        assert_eq!(average(1, 24, 5), Err(Error::OutputLength { needed: 6, given: 5 }));
        assert!(average(u32::MAX, 24, 6).is_err());
    }
}
