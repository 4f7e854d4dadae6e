//! The polynomial that lenses are made of.

use super::CLOSE;

/// g(r) = r (1 + k₁ r² + k₂ r⁴ + k₃ r⁶ + k₄ r⁸), as far as it grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Radial {
    pub(super) k: [f64; 4],
    /// The largest r that is shown: from there on g falls.
    pub(super) limit: f64,
}

/// Angles at which it is seen whether the polynomial still grows.
const ANGLES: u32 = 180;
/// Halvings that find where it stops.
const HALVINGS: usize = 50;
/// Steps that invert it at most: Newton's, or halvings where these leave the bracket.
const STEPS: usize = 60;

impl Radial {
    /// `r_of` turns an angle from the axis into r; `widest` is the largest angle.
    pub(super) fn new(k: [f64; 4], widest: f64, r_of: impl Fn(f64) -> f64) -> Self {
        let mut radial = Self { k, limit: r_of(widest) };
        let at = |i: u32| r_of(widest * f64::from(i) / f64::from(ANGLES));
        if let Some(i) = (1..=ANGLES).find(|i| radial.slope(at(*i)) <= 0.0) {
            let [mut grows, mut falls] = [at(i - 1), at(i)];
            for _ in 0..HALVINGS {
                let middle = 0.5 * (grows + falls);
                if radial.slope(middle) > 0.0 { grows = middle } else { falls = middle }
            }
            radial.limit = grows;
        }
        radial
    }

    /// g(r) / r for s = r².
    pub(super) fn factor(&self, s: f64) -> f64 {
        let [k1, k2, k3, k4] = self.k;
        1.0 + s * (k1 + s * (k2 + s * (k3 + s * k4)))
    }

    /// Its derivative by s.
    pub(super) fn factor_slope(&self, s: f64) -> f64 {
        let [k1, k2, k3, k4] = self.k;
        k1 + s * (2.0 * k2 + s * (3.0 * k3 + s * 4.0 * k4))
    }

    /// g(r).
    pub(super) fn at(&self, r: f64) -> f64 {
        r * self.factor(r * r)
    }

    /// g'(r).
    fn slope(&self, r: f64) -> f64 {
        let [k1, k2, k3, k4] = self.k;
        let s = r * r;
        1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * (7.0 * k3 + s * 9.0 * k4)))
    }

    /// At least |g'| and g / r everywhere up to r.
    pub(super) fn steepest(&self, r: f64) -> f64 {
        Self { k: self.k.map(f64::abs), limit: r }.slope(r)
    }

    /// The r of which g is this, and whether there is one; else the limit.
    pub(super) fn invert(&self, g: f64) -> (f64, bool) {
        if g.is_nan() || g > self.at(self.limit) {
            return (self.limit, false);
        }
        let [mut low, mut high] = [0.0, self.limit];
        let mut r = g.min(self.limit);
        for _ in 0..STEPS {
            let error = self.at(r) - g;
            if error > 0.0 {
                high = r;
            } else {
                low = r;
            }
            let newton = r - error / self.slope(r);
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            let done = (next - r).abs() <= 1e-15 * r;
            r = next;
            if done {
                break;
            }
        }
        (r, (self.at(r) - g).abs() < CLOSE)
    }
}
