//! A part of a photograph against the model's picture of it.

use glam::DVec2;

/// What the difference of photograph and picture is explained by, pixel by pixel, columns of the
/// least-squares problem: to first order (Lucas and Kanade 1981), a shift adds multiples of the
/// gradient, blur one of the Laplacian, and magnification one of the gradient away from the
/// principal point; where magnification depends on depth, one of this last, divided by depth.
const COLUMNS: usize = 6;
const GRADIENT_X: usize = 0;
const GRADIENT_Y: usize = 1;
pub(super) const LAPLACIAN: usize = 2;
pub(super) const RADIAL: usize = 3;
pub(super) const RADIAL_BY_DEPTH: usize = 4;
/// The difference itself.
pub(super) const DIFFERENCE: usize = 5;

/// Mean squared gradient of brightness, a pixel, below which a picture has nothing to compare.
const FLAT: f64 = 1e-4;

/// A part of the model's picture and of the photograph, both over the same background.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<'a> {
    /// RGB, three values a pixel.
    pub(super) model: &'a [f32],
    /// Distances, scene units; infinite where nothing is.
    pub(super) depth: &'a [f32],
    /// RGB; NaN where a pixel does not count.
    pub(super) photo: &'a [f32],
    /// Pixels along x.
    pub(super) width: usize,
    /// The principal point, pixels from the part's corner.
    pub(super) center: [f64; 2],
}

/// Sums over pixels of products of columns, of which some are eliminated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Products([[f64; COLUMNS]; COLUMNS]);

impl Products {
    pub(super) fn of(&self, a: usize, b: usize) -> f64 {
        self.0[a][b]
    }

    /// The same for what of each column a multiple of column `k` does not explain.
    #[must_use]
    pub(super) fn without(&self, k: usize) -> Self {
        let (m, pivot) = (&self.0, self.0[k][k]);
        if pivot <= 0.0 {
            return *self;
        }
        Self(std::array::from_fn(|a| std::array::from_fn(|b| m[a][b] - m[a][k] * m[k][b] / pivot)))
    }

    /// By how much of column `k` the difference is explained best.
    pub(super) fn share(&self, k: usize) -> f64 {
        self.0[DIFFERENCE][k] / self.0[k][k]
    }

    /// Without what a shift explains.
    #[must_use]
    pub(super) fn in_place(&self) -> Self {
        self.without(GRADIENT_X).without(GRADIENT_Y)
    }

    /// By how many pixels the photograph is shifted.
    pub(super) fn shift(&self) -> DVec2 {
        // It shows at x what the model shows at x - shift.
        -DVec2::new(
            self.without(GRADIENT_Y).share(GRADIENT_X),
            self.without(GRADIENT_X).share(GRADIENT_Y),
        )
    }

    /// How well the shift is known along the direction in which it is known least.
    pub(super) fn texture(&self) -> f64 {
        let [xx, yy] = [GRADIENT_X, GRADIENT_Y].map(|k| self.of(k, k));
        let xy = self.of(GRADIENT_X, GRADIENT_Y);
        0.5 * (xx + yy - DVec2::new(xx - yy, 2.0 * xy).length())
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (to, from) in self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()) {
            *to += from;
        }
    }
}

impl Pair<'_> {
    /// Compares the brightness of both, after the model's channels are scaled to the photograph's
    /// by least squares. `None` where these show nothing: edges along one axis alone say nothing
    /// of the other.
    pub(super) fn products(&self) -> Option<Products> {
        let Self { depth, width, center, .. } = *self;
        let (model, photo) = (self.model.as_chunks::<3>().0, self.photo.as_chunks::<3>().0);
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
        let (mut sums, mut n) = (Products::default(), 0.0);
        for y in 1..(model.len() / width).saturating_sub(1) {
            for x in 1..width.saturating_sub(1) {
                let i = y * width + x;
                let around = [i - 1, i + 1, i - width, i + width];
                if !depth[i].is_finite() || !around.into_iter().chain([i]).all(counts) {
                    continue;
                }
                let own = bright(model[i], gains);
                let [left, right, above, below] = around.map(|i| bright(model[i], gains));
                let gradient = 0.5 * DVec2::new(right - left, below - above);
                let from_center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - DVec2::from(center);
                let radial = gradient.dot(from_center);
                let columns = [
                    gradient.x,
                    gradient.y,
                    left + right + above + below - 4.0 * own,
                    radial,
                    radial / f64::from(depth[i]),
                    bright(photo[i], [1.0; 3]) - own,
                ];
                for (row, a) in sums.0.iter_mut().zip(columns) {
                    row.iter_mut().zip(columns).for_each(|(sum, b)| *sum += a * b);
                }
                n += 1.0;
            }
        }
        let [xx, xy, yy] = [[0, 0], [0, 1], [1, 1]].map(|[a, b]| sums.of(a, b));
        (n > 0.0 && xx * yy - xy * xy >= (FLAT * n).powi(2)).then_some(sums)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    const SIDE: usize = 40;

    /// Waves in both directions, seen as by a camera whose pixels are `at` those of the model's,
    /// `gain` times as bright.
    pub(in super::super) fn picture(at: impl Fn(DVec2) -> DVec2, gain: f64) -> Vec<f32> {
        let value = |i: usize| {
            let DVec2 { x, y } = at(DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5));
            (gain * (0.5 + 0.2 * (0.35 * x).sin() + 0.15 * (0.27 * y + 0.1 * x).cos())) as f32
        };
        (0..SIDE * SIDE).flat_map(|i| [value(i); 3]).collect()
    }

    /// The model's picture beside a photograph.
    pub(in super::super) fn compare(
        model: &[f32],
        photo: &[f32],
        depth: &[f32],
    ) -> Option<Products> {
        let center = [0.5 * SIDE as f64; 2];
        Pair { model, depth, photo, width: SIDE, center }.products()
    }

    fn shift(model: &[f32], photo: &[f32]) -> DVec2 {
        compare(model, photo, &[4.0; SIDE * SIDE]).unwrap().shift()
    }

    #[test]
    fn shifts_are_found() {
        let model = picture(|at| at, 1.0);
        assert!(shift(&model, &model).length() < 1e-6);
        let moved = DVec2::new(0.3, -0.4);
        let found = shift(&model, &picture(|at| at - moved, 1.0));
        assert!((found - moved).length() < 0.03, "{found}");
        let darker = shift(&model, &picture(|at| at, 0.9));
        assert!(darker.length() < 0.01, "{darker}");
        assert_eq!(compare(&[0.5; 4800], &[0.5; 4800], &[4.0; 1600]), None);
        let hidden: Vec<f32> = model.iter().map(|_| f32::NAN).collect();
        assert_eq!(compare(&model, &hidden, &[4.0; 1600]), None);
        // Stripes.
        let stripes = picture(|at| DVec2::new(at.x, -0.1 / 0.27 * at.x), 1.0);
        assert_eq!(compare(&stripes, &stripes, &[4.0; 1600]), None);
        assert_eq!(compare(&model, &model, &[f32::INFINITY; 1600]), None);
    }

    #[test]
    fn blur_is_a_share_of_the_laplacian() {
        let model = picture(|at| at, 1.0);
        // A filter of a third of each neighbour along x and y adds a third of the second
        // differences along both, to first order: waves change slowly here.
        let mut photo = model.clone();
        for y in 1..SIDE - 1 {
            for x in 1..SIDE - 1 {
                let at = |dx: usize, dy: usize| model[3 * ((y + dy - 1) * SIDE + x + dx - 1)];
                let sum: f32 = (0..9).map(|i| at(i % 3, i / 3)).sum();
                photo[3 * (y * SIDE + x)..][..3].fill(sum / 9.0);
            }
        }
        let blur = |photo: &[f32]| {
            let products = compare(&model, photo, &[4.0; SIDE * SIDE]).unwrap();
            products.in_place().share(LAPLACIAN)
        };
        let (same, blurred) = (blur(&model), blur(&photo));
        assert!(same.abs() < 1e-6 && (blurred - 1.0 / 3.0).abs() < 0.05, "{same} {blurred}");
    }

    #[test]
    fn magnification_by_depth_is_found() {
        let model = picture(|at| at, 1.0);
        let center = DVec2::splat(0.5 * SIDE as f64);
        // The left half is nearer and seen two parts in a hundred larger.
        let near = |at: DVec2| at.x < 20.0;
        let scale = |at: DVec2| if near(at) { 1.02 } else { 1.0 };
        let photo = picture(|at| center + (at - center) / scale(at), 1.0);
        let depth: Vec<f32> =
            (0..SIDE * SIDE).map(|i| if i % SIDE < 20 { 2.0 } else { 4.0 }).collect();
        let products = compare(&model, &photo, &depth).unwrap().without(RADIAL);
        // From a quarter to a half of a unit's inverse; the photograph at x is the model at x / s.
        let found = -products.share(RADIAL_BY_DEPTH);
        assert!((found - 0.02 / 0.25).abs() < 0.01, "{found}");
    }
}
