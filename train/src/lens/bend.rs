//! How a lens moves image points.

use super::radial::Radial;
use super::{CLOSE, STEPS};

/// With r² = x² + y² and the radial factor d, (x, y) moves to
/// (x d + 2 p₁ x y + p₂ (r² + 2 x²) + s₁ r², y d + p₁ (r² + 2 y²) + 2 p₂ x y + s₂ r²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    pub(super) radial: Radial,
    /// p₁ and p₂: lens and sensor are not parallel.
    pub(super) tangential: [f64; 2],
    /// s₁ and s₂: a thin prism.
    pub(super) prism: [f64; 2],
    /// How much x grows with y after all that: rows of the sensor that are not at right angles
    /// to its columns.
    pub(super) skew: f64,
}

impl Bend {
    pub(super) const fn radial(radial: Radial) -> Self {
        Self { radial, tangential: [0.0; 2], prism: [0.0; 2], skew: 0.0 }
    }

    /// Whether points move on lines through the middle.
    pub(super) fn is_radial(&self) -> bool {
        (self.tangential, self.prism) == ([0.0; 2], [0.0; 2])
    }

    /// Where a point moves; `None` where the lens does not show it.
    pub(super) fn distort(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        (x.hypot(y) <= self.radial.limit).then(|| {
            let [x, y] = self.apply([x, y]);
            [x + self.skew * y, y]
        })
    }

    fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([p1, p2], [s1, s2]) = (self.tangential, self.prism);
        let s = x * x + y * y;
        let d = self.radial.curve.factor(s);
        [
            x * d + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x) + s1 * s,
            y * d + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y + s2 * s,
        ]
    }

    /// The point that moves there, and whether there is one; else the farthest on that side.
    /// The radial part alone, then Newton's method, whose end is checked.
    pub(super) fn invert(&self, [x, y]: [f64; 2]) -> ([f64; 2], bool) {
        let shown = [x - self.skew * y, y];
        let radius = shown[0].hypot(shown[1]);
        let (r, found) = self.radial.invert(radius);
        let first = shown.map(|v| if radius > 0.0 { v * (r / radius) } else { v });
        if self.is_radial() {
            return (first, found);
        }
        let ([p1, p2], [s1, s2]) = (self.tangential, self.prism);
        let [mut x, mut y] = first;
        for _ in 0..STEPS {
            let at = self.apply([x, y]);
            let [ex, ey] = [at[0] - shown[0], at[1] - shown[1]];
            if ex.abs().max(ey.abs()) < CLOSE && x.hypot(y) <= self.radial.limit {
                return ([x, y], true);
            }
            let s = x * x + y * y;
            let curve = &self.radial.curve;
            let (d, slope) = (curve.factor(s), 2.0 * curve.factor_slope(s));
            let xx = d + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x + 2.0 * s1 * x;
            let yy = d + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x + 2.0 * s2 * y;
            let both = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
            let [xy, yx] = [both + 2.0 * s1 * y, both + 2.0 * s2 * x];
            let determinant = xx * yy - xy * yx;
            x -= (yy * ex - xy * ey) / determinant;
            y -= (xx * ey - yx * ex) / determinant;
        }
        (first, false)
    }

    /// At least how much a short way is stretched anywhere up to a radius.
    pub(super) fn steepest(&self, r: f64) -> f64 {
        let [p, s] = [self.tangential, self.prism].map(|[a, b]| a.abs() + b.abs());
        (self.radial.curve.steepest(r) + 8.0 * p * r + 2.0 * s * r) * (1.0 + self.skew.abs())
    }
}
