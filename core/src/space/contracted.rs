//! Contracted space: the space of scenes without an end.
//!
//! A cube around what matters keeps its shape; everything beyond it, to infinity, is brought
//! within twice its size. In units of half the cube's side, from its centre, a point p with the
//! largest coordinate |p_a| = m > 1 becomes
//!
//! ```text
//! p'_a = (2 - 1/m) sign(p_a)      p'_b = p_b / m   for the other two axes
//! ```
//!
//! (the piecewise-projective contraction of Reiser et al. 2023, MERF, equation 6). Straight lines
//! stay straight within the cube and within each of the six parts around it, so that a ray is a
//! few straight [pieces](Piece), one after another; equal steps along one that goes outwards are
//! equal steps in 1/m.

use crate::space::Piece;
use crate::{Error, Ray};

/// Contracted space: a cube that keeps its shape, and all that lies around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contracted {
    /// Centre of the cube, scene units.
    pub center: [f32; 3],
    /// Half of the cube's side, scene units: one local unit.
    pub radius: f32,
}

/// Share of the way to infinity that is as far as depths go.
const FARTHEST: f64 = 1.0 - 1.0 / (1 << 22) as f64;
/// Samples end so far before infinity, local units.
const MARGIN: f64 = 1e-5;
/// The cube, and what lies beyond each of its faces.
const PARTS: usize = 7;

/// A part of a ray that lies in one part of the space, in f64: what is rounded at the end
/// is the same for everyone who computes it.
#[derive(Clone, Copy)]
struct Stretch {
    /// Local points at both ends.
    from: [f64; 3],
    way: [f64; 3],
    /// Length of the way.
    length: f64,
    /// Distance along the public ray to where it begins, in radii.
    begin: f64,
    /// Largest coordinate there, and how much it grows a radius.
    largest: f64,
    growth: f64,
    /// What the distance over the largest coordinate is at the end.
    ratio: f64,
}

/// The stretches of a ray, nearest first.
struct Walk {
    origin: [f64; 3],
    direction: [f64; 3],
    /// The part in which the next one lies; none behind the last.
    part: Option<usize>,
    begin: f64,
}

impl Walk {
    /// The largest coordinate of part `part` at the origin, and how much it grows: that of
    /// the cube is 1. Where a point lies is the part with the greatest.
    fn largest(&self, part: usize) -> [f64; 2] {
        if part == 0 {
            return [1.0, 0.0];
        }
        let (axis, sign) = place(part);
        [sign * self.origin[axis], sign * self.direction[axis]]
    }

    /// The local point of part `part` at a distance; where that is infinite, its limit.
    fn image(&self, part: usize, distance: f64) -> [f64; 3] {
        let p = |a: usize| self.origin[a] + distance * self.direction[a];
        if part == 0 {
            return [p(0), p(1), p(2)];
        }
        let (axis, sign) = place(part);
        let [start, growth] = self.largest(part);
        let mut image = [0.0; 3];
        for (a, to) in image.iter_mut().enumerate() {
            *to = match (a == axis, distance.is_finite()) {
                (true, true) => sign * (2.0 - 1.0 / (start + growth * distance)),
                (true, false) => sign * 2.0,
                (false, true) => p(a) / (start + growth * distance),
                (false, false) => self.direction[a] / growth,
            };
        }
        image
    }
}

/// Axis and sign of a part beside the cube.
const fn place(part: usize) -> (usize, f64) {
    ((part - 1) / 2, if part % 2 == 1 { 1.0 } else { -1.0 })
}

impl Iterator for Walk {
    type Item = Stretch;

    fn next(&mut self) -> Option<Stretch> {
        let part = self.part?;
        let [start, growth] = self.largest(part);
        // Which part takes over, and where: one that grows faster. Of those that do so at
        // the same place, the fastest.
        let (mut end, mut next) = (f64::INFINITY, None);
        for other in 0..PARTS {
            let [theirs, faster] = self.largest(other);
            if faster > growth {
                let at = ((start - theirs) / (faster - growth)).max(self.begin);
                let before = next.map_or(f64::NEG_INFINITY, |next| self.largest(next)[1]);
                if at < end || (at == end && faster > before) {
                    (end, next) = (at, Some(other));
                }
            }
        }
        let begin = self.begin;
        (self.part, self.begin) = (next, end);
        let from = self.image(part, begin);
        let to = self.image(part, end);
        let way = [0, 1, 2].map(|a| to[a] - from[a]);
        let largest = start + growth * begin;
        let ratio = match end.is_finite() {
            true => (end - begin) / (start + growth * end),
            false => 1.0 / growth,
        };
        let length = sqrt(way.iter().map(|w| w * w).sum());
        Some(Stretch { from, way, length, begin, largest, growth, ratio })
    }
}

impl Stretch {
    /// Distance along the public ray, radii, where the share `share` of the way lies behind.
    fn distance(&self, share: f64) -> f64 {
        let part = share.clamp(0.0, FARTHEST) * self.ratio;
        self.begin + part * self.largest / (1.0 - part * self.growth)
    }
}

impl Contracted {
    pub(super) fn validate(&self) -> Result<(), Error> {
        let sound = self.center.iter().all(|c| c.abs() < 1e6) && (1e-6..1e6).contains(&self.radius);
        if sound { Ok(()) } else { Err(Error::Range("contracted space")) }
    }

    pub(super) const fn bounds(&self) -> [[f32; 3]; 2] {
        [[-2.0; 3], [2.0; 3]]
    }

    /// `None` for rays that are none.
    fn walk(&self, ray: &Ray) -> Option<Walk> {
        let finite = ray.origin.iter().chain(&ray.direction).all(|v| v.is_finite());
        let square: f32 = ray.direction.iter().map(|d| d * d).sum();
        if !(finite && square > 0.25) {
            return None;
        }
        let radius = f64::from(self.radius);
        let origin =
            [0, 1, 2].map(|a| (f64::from(ray.origin[a]) - f64::from(self.center[a])) / radius);
        let direction = ray.direction.map(f64::from);
        let mut walk = Walk { origin, direction, part: None, begin: 0.0 };
        let mut first = 0;
        for part in 1..PARTS {
            let ([a, b], [c, d]) = (walk.largest(part), walk.largest(first));
            if a > c || (a == c && b > d) {
                first = part;
            }
        }
        walk.part = Some(first);
        Some(walk)
    }

    /// The straight piece on which the distance `t` of a public ray lies.
    #[inline(never)]
    pub(super) fn piece(&self, ray: &Ray, t: f32) -> Option<Piece> {
        let mut before = 0.0;
        let mut walk = self.walk(ray)?;
        while let Some(Stretch { from, way, length, .. }) = walk.next() {
            let is_last = walk.part.is_none();
            let end = (before + length - if is_last { MARGIN } else { 0.0 }) as f32;
            if t < end && length > 0.0 {
                let direction = way.map(|v| v / length);
                let origin = [0, 1, 2].map(|a| (from[a] - before * direction[a]) as f32);
                let local = Ray { origin, direction: direction.map(|v| v as f32) };
                let finite = local.origin.iter().chain(&local.direction).all(|v| v.is_finite());
                return finite.then_some(Piece { local, end });
            }
            before += length;
        }
        None
    }

    /// How far the public ray goes until infinity, or nearly: its last point is on a piece.
    pub(super) fn length(&self, ray: &Ray) -> f32 {
        let length: f64 = self.walk(ray).into_iter().flatten().map(|s| s.length).sum();
        (length - 2.0 * MARGIN).max(0.0) as f32
    }

    #[inline(never)]
    pub(super) fn depth(&self, ray: &Ray, t: f32) -> f32 {
        let (true, Some(walk)) = (t.is_finite(), self.walk(ray)) else { return t };
        let (mut before, mut last) = (0.0, 0.0);
        for stretch in walk {
            let share = (f64::from(t) - before) / stretch.length;
            last = if stretch.length > 0.0 { stretch.distance(share) } else { last };
            if share <= 1.0 {
                break;
            }
            before += stretch.length;
        }
        ((last * f64::from(self.radius)) as f32).min(f32::MAX)
    }

    pub(super) fn scene_point(&self, p: [f32; 3]) -> [f32; 3] {
        let axis = farthest_axis(p);
        let largest = p[axis].abs();
        let mut q = p;
        if largest > 1.0 {
            let m = 1.0 / (2.0 - largest).max(1e-6);
            q = p.map(|v| v * m);
            q[axis] = if p[axis] < 0.0 { -m } else { m };
        }
        [0, 1, 2].map(|a| self.center[a] + q[a] * self.radius)
    }

    /// From the cube's faces it is seen whole.
    pub(super) const fn viewing_distance(&self) -> f32 {
        self.radius
    }

    /// Scene point to local point.
    #[must_use]
    pub fn local_point(&self, p: [f32; 3]) -> [f32; 3] {
        let q = [0, 1, 2].map(|a| (p[a] - self.center[a]) / self.radius);
        let axis = farthest_axis(q);
        let m = q[axis].abs();
        if m <= 1.0 {
            return q;
        }
        let mut image = q.map(|v| v / m);
        image[axis] = if q[axis] < 0.0 { 1.0 / m - 2.0 } else { 2.0 - 1.0 / m };
        image
    }
}

/// The axis along which a point lies farthest out.
fn farthest_axis(p: [f32; 3]) -> usize {
    (1..3).fold(0, |most, a| if p[a].abs() > p[most].abs() { a } else { most })
}

/// Square root to the last bits, of numbers far from the ends of f32's range.
fn sqrt(x: f64) -> f64 {
    let guess = f64::from(crate::math::sqrt(x as f32));
    if guess > 0.0 { 0.5 * (guess + x / guess) } else { 0.0 }
}

#[cfg(test)]
mod tests;
