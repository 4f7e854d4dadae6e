//! What the training images are like on average.

use super::rays::{Pixel, RaySource};
use super::visibility::PixelVisibility;

/// Every so many pixels count for [`Targets`]: images of 800x800 give ten
/// thousand each. A prime, so that all columns have their turn.
const PIXELS_APART: usize = 61;

/// What the training images are like on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Targets {
    /// Mean alpha.
    pub alpha: f64,
    /// Mean squared error of a model that has learnt nothing: the background alone, or the
    /// mean colour everywhere, whichever is better.
    pub trivial_error: f64,
    /// Share of that error, if everything were transparent, that lies in pixels
    /// which training does not draw: none can be explained.
    pub unseen_error: f64,
    /// The same as a share of that error of all pixels: how much of what the images show lies
    /// where nothing can be learnt.
    pub unseen_share: f64,
}

impl RaySource {
    /// Averages over a fixed share of the pixels that count.
    #[must_use]
    pub(crate) fn targets(&self, visibility: &PixelVisibility) -> Targets {
        let (mut n, mut alpha, mut nothing, mut unseen) = (0.0, 0.0, 0.0, 0.0);
        let (mut sum, mut sum_of_squares) = ([0.0; 3], 0.0);
        // Pixels of all images before this one.
        let mut before = 0usize;
        let pixels = self.images().iter().enumerate().flat_map(|(view, image)| {
            let pixels = image.as_chunks::<4>().0;
            let first = before.next_multiple_of(PIXELS_APART) - before;
            before += pixels.len();
            let counted = (first..pixels.len()).step_by(PIXELS_APART);
            counted.map(move |i| (view, i, self.exposure().even(view, pixels[i])))
        });
        for (view, i, pixel) in pixels.filter(|(view, i, _)| self.is_exact(*view, *i)) {
            let (mean, variance) = self.moments(view, pixel[3]);
            let (mean, variance) = (mean.map(f64::from), f64::from(variance));
            let square = mean.map(|mean| mean * mean + variance);
            let [r, g, b, a] = [0, 1, 2, 3].map(|i| f64::from(pixel[i]) / 255.0);
            n += 1.0;
            alpha += a;
            let width = self.cameras()[view].width;
            let (x, y) = (i as u32 % width, i as u32 / width);
            let drawn = visibility.draws(Pixel { view: view as u32, x, y });
            for (c, value) in [r, g, b].into_iter().enumerate() {
                let (own, through) = (a * value, 1.0 - a);
                let error = own * own - 2.0 * own * a * mean[c] + a * a * square[c];
                nothing += error;
                unseen += if drawn { 0.0 } else { error };
                sum[c] += own + through * mean[c];
                sum_of_squares +=
                    own * own + 2.0 * own * through * mean[c] + through * through * square[c];
            }
        }
        let n = f64::max(n, 1.0);
        let wall = sum_of_squares / n - sum.map(|s| (s / n) * (s / n)).iter().sum::<f64>();
        Targets {
            alpha: alpha / n,
            trivial_error: f64::min(nothing / n, wall).max(0.0) / 3.0,
            unseen_error: unseen.max(0.0) / (3.0 * n),
            unseen_share: (unseen / nothing.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0),
        }
    }
}
