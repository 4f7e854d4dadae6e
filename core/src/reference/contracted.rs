//! Contracted space in f64: a ray cut wherever two coordinates are equally large, each piece
//! between the images of its ends.

use super::math::sqrt;
use crate::Ray;
use crate::space::Contracted;

/// Pairs of the functions 1, ±x, ±y and ±z, with the ends.
const MOST: usize = 23;
/// Local units before infinity in which there are no samples.
const MARGIN: f64 = 1e-5;

/// A straight piece of a ray.
#[derive(Clone, Copy)]
struct Piece {
    local: Ray,
    /// Local distances of its ends along the ray.
    begin: f64,
    length: f64,
    /// As it is compared with those of samples.
    end: f32,
    from: [f64; 3],
    way: [f64; 3],
    part: Part,
}

/// The cube, or what lies beyond one of its faces.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Cube,
    Beyond(usize, f64),
}

/// The pieces of a ray.
pub(super) struct Pieces {
    space: Contracted,
    ray: Ray,
    pieces: [Option<Piece>; MOST],
}

impl Pieces {
    pub(super) fn new(space: &Contracted, ray: &Ray) -> Option<Self> {
        let sound = ray.origin.iter().chain(&ray.direction).all(|v| v.is_finite());
        if !sound || ray.direction.iter().all(|d| *d == 0.0) {
            return None;
        }
        let o = normalised(space, ray.origin);
        let d = ray.direction.map(f64::from);
        let at = |s: f64| [0, 1, 2].map(|a| o[a] + s * d[a]);
        // Distances at which any two of the functions are equal.
        let line = |i: usize| match i {
            0 => (1.0, 0.0),
            i if i < 4 => (o[i - 1], d[i - 1]),
            i => (-o[i - 4], -d[i - 4]),
        };
        let (mut cuts, mut n) = ([f64::INFINITY; MOST], 1);
        cuts[0] = 0.0;
        for i in 0..7 {
            for j in 0..i {
                let s = (line(j).0 - line(i).0) / (line(i).1 - line(j).1);
                if s > 0.0 && s.is_finite() {
                    cuts[n] = s;
                    n += 1;
                }
            }
        }
        cuts[..n].sort_unstable_by(f64::total_cmp);
        let mut pieces = [None; MOST];
        let (mut count, mut start, mut before) = (0, 0.0, 0.0);
        for i in 0..n {
            let end = if i + 1 < n { cuts[i + 1] } else { f64::INFINITY };
            let inside = |from: f64, to: f64| match to.is_finite() {
                true => part(at(0.5 * (from + to))),
                false => part(at(2.0 * from + 1e3)),
            };
            let own = inside(cuts[i], end);
            let goes_on = i + 1 < n && {
                let after = if i + 2 < n { cuts[i + 2] } else { f64::INFINITY };
                inside(end, after) == own
            };
            if goes_on || end <= start {
                continue;
            }
            let from = image(own, at(start));
            let to = if end.is_finite() { image(own, at(end)) } else { limit(d) };
            let way = [0, 1, 2].map(|a| to[a] - from[a]);
            let length = sqrt(way.iter().map(|w| w * w).sum());
            let direction = way.map(|w| w / length);
            let origin = [0, 1, 2].map(|a| (from[a] - before * direction[a]) as f32);
            let margin = if end.is_finite() { 0.0 } else { MARGIN };
            pieces[count] = Some(Piece {
                local: Ray { origin, direction: direction.map(|v| v as f32) },
                begin: before,
                length,
                end: (before + length - margin) as f32,
                from,
                way,
                part: own,
            });
            before += length;
            start = end;
            count += 1;
        }
        Some(Self { space: *space, ray: *ray, pieces })
    }

    /// The local point at distance `t`; `None` behind infinity.
    pub(super) fn point(&self, t: f32) -> Option<[f32; 3]> {
        let piece = self.pieces.iter().flatten().find(|piece| t < piece.end)?;
        Some(super::ray::point(&piece.local, t))
    }

    /// Length of them all, to just before the end.
    pub(super) fn length(&self) -> f32 {
        let last = self.pieces.iter().flatten().last();
        last.map_or(0.0, |last| (last.begin + last.length - 2.0 * MARGIN) as f32)
    }

    /// From the local point at distance `t` back to the scene.
    pub(super) fn depth(&self, t: f64) -> f64 {
        let piece = self.pieces.iter().flatten().find(|piece| t <= piece.begin + piece.length);
        let Some(piece) = piece.or_else(|| self.pieces.iter().flatten().last()) else { return t };
        let share = ((t - piece.begin) / piece.length).clamp(0.0, 1.0 - 1e-7);
        let mut p = [0, 1, 2].map(|a| piece.from[a] + share * piece.way[a]);
        if let Part::Beyond(axis, sign) = piece.part {
            let m = 1.0 / (2.0 - sign * p[axis]).max(1e-7);
            p = p.map(|v| v * m);
            p[axis] = sign * m;
        }
        let o = normalised(&self.space, self.ray.origin);
        let along: f64 = (0..3).map(|a| (p[a] - o[a]) * f64::from(self.ray.direction[a])).sum();
        along * f64::from(self.space.radius)
    }
}

/// The local coordinates of a scene point.
pub(super) fn point(space: &Contracted, p: [f32; 3]) -> [f32; 3] {
    let q = normalised(space, p);
    image(part(q), q).map(|v| v as f32)
}

/// In radii, from the centre.
fn normalised(space: &Contracted, p: [f32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|a| (f64::from(p[a]) - f64::from(space.center[a])) / f64::from(space.radius))
}

fn part(p: [f64; 3]) -> Part {
    let axis = (1..3).fold(0, |most, a| if p[a].abs() > p[most].abs() { a } else { most });
    if p[axis].abs() <= 1.0 { Part::Cube } else { Part::Beyond(axis, p[axis].signum()) }
}

fn image(part: Part, p: [f64; 3]) -> [f64; 3] {
    let Part::Beyond(axis, sign) = part else { return p };
    let m = sign * p[axis];
    let mut image = p.map(|v| v / m);
    image[axis] = sign * (2.0 - 1.0 / m);
    image
}

/// Where a direction vanishes.
fn limit(d: [f64; 3]) -> [f64; 3] {
    let axis = (1..3).fold(0, |most, a| if d[a].abs() > d[most].abs() { a } else { most });
    let mut image = d.map(|v| v / d[axis].abs());
    image[axis] *= 2.0;
    image
}
