//! How bright a picture is beside the truth, fitted on one half, so that the other half shows how
//! good it is apart from that (Martin-Brualla et al. 2021, "NeRF in the Wild").

use pocketnerf_core::ColorSpace;

use crate::dataset::View;
use crate::picture::Picture;

/// Factors beyond these are taken for these.
const MOST: f64 = 16.0;

/// Whether a pixel of a row of so many is in the left half, which is fitted.
fn is_left(x: usize, width: usize) -> bool {
    x < width / 2
}

/// Multiplies each channel of what is rendered by the factor that brings its left half nearest to
/// the view's, by least squares, and gives the factors. Of values that are as bright as can be
/// nothing is known; a channel without others keeps 1.
pub(crate) fn fit(picture: &mut Picture, view: &View, space: ColorSpace) -> [f32; 3] {
    let width = (picture.width as usize).max(1);
    let (mut along, mut square) = ([0.0; 3], [0.0; 3]);
    let pixels = picture.rgba.as_chunks::<4>().0.iter().zip(view.rgba.as_chunks::<4>().0);
    for (i, (rendered, truth)) in pixels.enumerate() {
        let counts = view.mask.as_ref().is_none_or(|mask| mask[i] != 0);
        if !counts || !is_left(i % width, width) {
            continue;
        }
        let alpha = f32::from(truth[3]) / 255.0;
        let straight = [0, 1, 2].map(|c| f32::from(truth[c]) / 255.0);
        let shown = space.from_srgb(straight).map(|value| f64::from(alpha * value));
        for c in (0..3).filter(|c| truth[*c] < u8::MAX) {
            let value = f64::from(rendered[c]);
            along[c] += value * shown[c];
            square[c] += value * value;
        }
    }
    let factor = |c: usize| match along[c] > 0.0 && square[c] > 0.0 {
        true => (along[c] / square[c]).clamp(1.0 / MOST, MOST) as f32,
        false => 1.0,
    };
    let factors = [0, 1, 2].map(factor);
    for pixel in picture.rgba.as_chunks_mut::<4>().0 {
        for (value, factor) in pixel.iter_mut().zip(factors) {
            *value *= factor;
        }
        // No brighter than an image can be.
        let [_, _, _, alpha] = *pixel;
        pixel.iter_mut().for_each(|value| *value = value.min(alpha));
    }
    factors
}

/// The mask that leaves the right half of a view to be compared; `None` where nothing there
/// counts.
pub(crate) fn right_half(view: &View) -> Option<Vec<u8>> {
    let (width, height) = (view.camera.width as usize, view.camera.height as usize);
    let counts = |i: usize| {
        let own = view.mask.as_ref().is_none_or(|mask| mask[i] != 0);
        u8::from(own && !is_left(i % width, width))
    };
    let mask: Vec<u8> = (0..width * height).map(counts).collect();
    mask.contains(&1).then_some(mask)
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::Camera;

    use super::*;

    #[test]
    fn a_factor_of_the_left_half_by_hand() {
        let pose = Camera::look_at([3.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(4, 1, 0.5, pose);
        // Red is half as bright to the left, green cut off, blue unknown; the right differs.
        let left = [51, 255, 0, 255];
        let rgba = [left, left, [255, 1, 1, 255], [0, 0, 0, 255]].concat();
        let view = View::new("", camera, rgba);
        let pixel = [0.4, 0.2, 0.0, 1.0];
        let mut picture = Picture {
            width: 4,
            height: 1,
            rgba: [pixel, pixel, [1.0, 0.4, 0.1, 1.0], [0.2, 0.2, 0.2, 0.2]].concat(),
            depth: Vec::new(),
            stats: Default::default(),
        };
        let factors = fit(&mut picture, &view, ColorSpace::Srgb);
        assert!((factors[0] - 0.5).abs() < 1e-6 && factors[1..] == [1.0; 2], "{factors:?}");
        let expected = [0.2, 0.2, 0.0, 1.0, 0.2, 0.2, 0.0, 1.0, 0.5, 0.4, 0.1, 1.0];
        assert!(picture.rgba.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6));
        assert_eq!(right_half(&view), Some(vec![0, 0, 1, 1]));
        let mut masked = view;
        masked.mask = Some(vec![0, 0, 0, 1]);
        assert_eq!(fit(&mut picture, &masked, ColorSpace::Srgb), [1.0; 3]);
        assert_eq!(right_half(&masked), Some(vec![0, 0, 0, 1]));
        masked.mask = Some(vec![1, 1, 0, 0]);
        assert_eq!(right_half(&masked), None);
    }
}
