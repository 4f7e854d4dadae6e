//! A photograph against the model's picture from its camera: how far it is shifted, and how sharp
//! it is.

use glam::{DMat2, DVec2};

/// What a photograph differs by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    /// By how many pixels it is shifted.
    pub(super) shift: f64,
    /// Sums of squared gradients of brightness: of the photograph, and of the model's picture.
    pub(super) edges: [f64; 2],
}

/// Mean squared gradient of brightness, a pixel, below which a picture has nothing to compare.
const FLAT: f64 = 1e-4;

/// Compares the model's RGB with a photograph's, both over the same background, `width` pixels
/// wide. `None` where these show nothing.
///
/// The shift minimises the squared difference of brightness to first order (Lucas and Kanade 1981),
/// after the model's channels are scaled to the photograph's by least squares.
pub(super) fn compare(model: &[f32], photo: &[f32], width: usize) -> Option<Look> {
    let (model, photo) = (model.as_chunks::<3>().0, photo.as_chunks::<3>().0);
    let counts = |i: usize| photo[i].iter().chain(&model[i]).all(|value| value.is_finite());
    let (mut products, mut squares) = ([0.0; 3], [0.0; 3]);
    for i in (0..model.len()).filter(|i| counts(*i)) {
        for c in 0..3 {
            products[c] += f64::from(photo[i][c] * model[i][c]);
            squares[c] += f64::from(model[i][c] * model[i][c]);
        }
    }
    if squares.contains(&0.0) {
        return None;
    }
    let gains = [0, 1, 2].map(|c| products[c] / squares[c]);
    let bright = |of: [f32; 3], gains: [f64; 3]| -> f64 {
        of.iter().zip(gains).map(|(value, gain)| f64::from(*value) * gain).sum::<f64>() / 3.0
    };
    let height = model.len() / width;
    let (mut matrix, mut right, mut n) = (DMat2::ZERO, DVec2::ZERO, 0.0);
    let mut edges = 0.0;
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            let i = y * width + x;
            let around = [i - 1, i + 1, i - width, i + width];
            if !around.into_iter().chain([i]).all(counts) {
                continue;
            }
            let [left, after, above, below] = around.map(|i| bright(model[i], gains));
            let gradient = 0.5 * DVec2::new(after - left, below - above);
            let own = around.map(|i| bright(photo[i], [1.0; 3]));
            edges += 0.25 * DVec2::new(own[1] - own[0], own[3] - own[2]).length_squared();
            let off = bright(photo[i], [1.0; 3]) - bright(model[i], gains);
            matrix += DMat2::from_cols(gradient * gradient.x, gradient * gradient.y);
            // The photograph shows at x what the model shows at x - shift.
            right -= gradient * off;
            n += 1.0;
        }
    }
    // Edges along one axis alone say nothing of the other.
    if matrix.determinant() < (FLAT * n).powi(2) || n == 0.0 {
        return None;
    }
    let shift = (matrix.inverse() * right).length();
    let edges = [edges, matrix.x_axis.x + matrix.y_axis.y];
    Some(Look { shift, edges })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waves in both directions, moved by a part of a pixel, `gain` times as bright.
    fn picture(moved: [f64; 2], gain: f64) -> Vec<f32> {
        let at = |x: usize, y: usize| {
            let (x, y) = (x as f64 - moved[0], y as f64 - moved[1]);
            (gain * (0.5 + 0.2 * (0.35 * x).sin() + 0.15 * (0.27 * y + 0.1 * x).cos())) as f32
        };
        (0..40 * 40).flat_map(|i| [at(i % 40, i / 40); 3]).collect()
    }

    #[test]
    fn shift_and_sharpness_are_found() {
        let model = picture([0.0; 2], 1.0);
        let same = compare(&model, &model, 40).unwrap();
        assert!(same.shift < 1e-6);
        assert!((same.edges[0] / same.edges[1] - 1.0).abs() < 1e-6);
        let moved = compare(&model, &picture([0.3, -0.4], 1.0), 40).unwrap();
        assert!((moved.shift - 0.5).abs() < 0.03, "{moved:?}");
        let darker = compare(&model, &picture([0.0; 2], 0.9), 40).unwrap();
        assert!(darker.shift < 0.01, "{darker:?}");
        // Of half the contrast: a quarter of the squared gradient, once its brightness is the same.
        let soft: Vec<f32> = model.iter().map(|value| 0.25 + 0.5 * value).collect();
        let [photo, own] = compare(&model, &soft, 40).unwrap().edges;
        let soft = photo / own;
        assert!((0.2..0.4).contains(&soft), "{soft}");
        assert_eq!(compare(&[0.5; 4800], &[0.5; 4800], 40), None);
        let hidden: Vec<f32> = model.iter().map(|_| f32::NAN).collect();
        assert_eq!(compare(&model, &hidden, 40), None);
    }
}
