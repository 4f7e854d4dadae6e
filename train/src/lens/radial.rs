//! The curve that lenses are made of: from the radius of a direction to that of its image point.

use super::CLOSE;

/// g(r), as far as it grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Radial {
    pub(super) curve: Curve,
    /// The largest r that is shown: from there on g falls.
    pub(super) limit: f64,
}

/// What g(r) is, with s = r².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Curve {
    /// r (1 + k₁ s + k₂ s² + k₃ s³ + k₄ s⁴)
    Polynomial([f64; 4]),
    /// r (1 + k₁ s + k₂ s² + k₃ s³) / (1 + k₄ s + k₅ s² + k₆ s³)
    Rational([f64; 3], [f64; 3]),
    /// atan(2 r tan(ω / 2)) / ω
    Fov(f64),
}

/// Angles at which it is seen whether the curve still grows.
const ANGLES: u32 = 180;
/// A denominator that is this small belongs to a pole.
const POLE: f64 = 1e-3;
/// Halvings that find where it stops.
const HALVINGS: usize = 50;
/// Steps that invert it at most: Newton's, or halvings where these leave the bracket.
const STEPS: usize = 60;

impl Radial {
    /// `r_of` turns an angle from the axis into r; `widest` is the largest angle.
    pub(super) fn new(curve: Curve, widest: f64, r_of: impl Fn(f64) -> f64) -> Self {
        let mut radial = Self { curve, limit: r_of(widest) };
        let at = |i: u32| r_of(widest * f64::from(i) / f64::from(ANGLES));
        if let Some(i) = (1..=ANGLES).find(|i| curve.slope(at(*i)) <= 0.0) {
            let [mut grows, mut falls] = [at(i - 1), at(i)];
            for _ in 0..HALVINGS {
                let middle = 0.5 * (grows + falls);
                if curve.slope(middle) > 0.0 { grows = middle } else { falls = middle }
            }
            radial.limit = grows;
        }
        radial
    }

    /// g(r).
    pub(super) fn at(&self, r: f64) -> f64 {
        r * self.curve.factor(r * r)
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
            let newton = r - error / self.curve.slope(r);
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

impl Curve {
    /// g(r) / r for s = r².
    pub(super) fn factor(&self, s: f64) -> f64 {
        match self {
            Self::Polynomial(k) => 1.0 + s * sum(k, s, |_| 1.0),
            Self::Rational(k, below) => {
                (1.0 + s * sum(k, s, |_| 1.0)) / (1.0 + s * sum(below, s, |_| 1.0))
            }
            Self::Fov(omega) => {
                let (r, scale) = (s.sqrt(), fov_scale(*omega));
                if r > 0.0 { (scale * r).atan() / (omega * r) } else { scale / omega }
            }
        }
    }

    /// Its derivative by s.
    pub(super) fn factor_slope(&self, s: f64) -> f64 {
        match self {
            Self::Polynomial(k) => sum(k, s, |power| power),
            Self::Rational(k, below) => {
                let [n, d] = [&k[..], below].map(|k| 1.0 + s * sum(k, s, |_| 1.0));
                let [by_n, by_d] = [&k[..], below].map(|k| sum(k, s, |power| power));
                (by_n * d - n * by_d) / (d * d)
            }
            // From g' = factor + 2 s factor'.
            Self::Fov(_) if s > 0.0 => 0.5 * (self.slope(s.sqrt()) - self.factor(s)) / s,
            Self::Fov(omega) => -fov_scale(*omega).powi(3) / (3.0 * omega),
        }
    }

    /// g'(r).
    fn slope(&self, r: f64) -> f64 {
        let s = r * r;
        match self {
            Self::Polynomial(k) => 1.0 + s * sum(k, s, |power| 2.0 * power + 1.0),
            // At a pole and beyond nothing is shown.
            Self::Rational(_, below) if 1.0 + s * sum(below, s, |_| 1.0) <= POLE => -1.0,
            Self::Rational(..) => self.factor(s) + 2.0 * s * self.factor_slope(s),
            Self::Fov(omega) => {
                let scale = fov_scale(*omega);
                scale / (omega * (1.0 + scale * scale * s))
            }
        }
    }

    /// At least |g'| and g / r everywhere up to r.
    pub(super) fn steepest(&self, r: f64) -> f64 {
        match self {
            Self::Polynomial(k) => Self::Polynomial(k.map(f64::abs)).slope(r),
            Self::Rational(k, below) => {
                let (s, k, below) = (r * r, k.map(f64::abs), below.map(f64::abs));
                let least = 1.0 - s * sum(&below, s, |_| 1.0);
                if least <= 0.0 {
                    return f64::INFINITY;
                }
                let [n, by_n] = [1.0 + s * sum(&k, s, |_| 1.0), sum(&k, s, |power| power)];
                let by_d = sum(&below, s, |power| power);
                n / least + 2.0 * s * (by_n / least + n * by_d / (least * least))
            }
            // It is steepest on the axis.
            Self::Fov(_) => self.slope(0.0),
        }
    }
}

/// w(1) k₁ + w(2) k₂ s + w(3) k₃ s² and so on, for weights of the powers of s in s (k₁ + k₂ s + …).
fn sum(k: &[f64], s: f64, weight: impl Fn(f64) -> f64) -> f64 {
    let powers = (1..=k.len()).rev().map(|power| power as f64);
    powers.zip(k.iter().rev()).fold(0.0, |sum, (power, k)| weight(power) * k + s * sum)
}

/// What radii are multiplied with before their arc tangent.
fn fov_scale(omega: f64) -> f64 {
    2.0 * (0.5 * omega).tan()
}
