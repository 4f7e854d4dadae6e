//! The solids of the built-in scenes and where a ray enters them.
//!
//! All are convex: a ray from outside meets each at most once from the front,
//! and no solid casts a shadow on its own lit side.

use glam::{DMat3, DVec2, DVec3};

/// A solid, in scene units.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    /// An ellipsoid with its axes along x, y and z.
    Ellipsoid { center: DVec3, radii: DVec3 },
    /// A box turned about the z axis; `turn` is the unit vector along its own x axis.
    Block { center: DVec3, half: DVec3, turn: DVec2 },
    /// An upright cylinder with flat ends; `base` is the centre of its foot.
    Cylinder { base: DVec3, radius: f64, height: f64 },
    /// A cylinder without ends: both are hidden inside other solids.
    Wire { from: DVec3, to: DVec3, radius: f64 },
    /// An ellipsoid with any axes: `axes` are unit vectors at right angles, along the first
    /// of which it is longest.
    Leaf { center: DVec3, axes: DMat3, radii: DVec3 },
    /// A roof: a prism whose ridge runs above the middle of its base along `turn`, a unit
    /// vector; `half` is half the base's length along the ridge and half its width.
    Gable { base: DVec3, half: DVec2, height: f64, turn: DVec2 },
    /// All that lies below a height.
    Ground { height: f64 },
}

/// Where a ray enters a solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Distance along the ray, scene units.
    pub(super) t: f64,
    /// The outward unit normal.
    pub(super) normal: DVec3,
}

impl Shape {
    /// A ball.
    pub(super) fn sphere(center: DVec3, radius: f64) -> Self {
        Self::Ellipsoid { center, radii: DVec3::splat(radius) }
    }

    /// A box along the scene's axes.
    pub(super) fn block(center: DVec3, half: DVec3) -> Self {
        Self::Block { center, half, turn: DVec2::X }
    }

    /// Where the ray from `origin` along the unit vector `direction` enters,
    /// if that lies ahead.
    pub(super) fn enter(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        match *self {
            Self::Ellipsoid { center, radii } => {
                // In units of the radii the ellipsoid is the unit sphere, at the same t.
                let o = (origin - center) / radii;
                let d = direction / radii;
                let t = nearer_root(d.dot(d), o.dot(d), o.dot(o) - 1.0)?;
                Some(Hit { t, normal: ((o + d * t) / radii).normalize() })
            }
            Self::Block { center, half, turn } => {
                let o = into_block(origin - center, turn);
                let d = into_block(direction, turn);
                let [enter, leave] = slabs(half, o, d);
                let t = enter.max_element();
                if !(t > 0.0 && t <= leave.min_element()) {
                    return None;
                }
                // The face that is entered last.
                let faces = enter.cmpge(DVec3::splat(t));
                let face = if faces.x {
                    DVec3::new(-d.x.signum(), 0.0, 0.0)
                } else if faces.y {
                    DVec3::new(0.0, -d.y.signum(), 0.0)
                } else {
                    DVec3::new(0.0, 0.0, -d.z.signum())
                };
                Some(Hit { t, normal: into_block(face, DVec2::new(turn.x, -turn.y)) })
            }
            Self::Cylinder { base, radius, height } => {
                let o = origin - base;
                let d = direction;
                let (oxy, dxy) = (o.truncate(), d.truncate());
                let [side, end, leave] = cylinder(radius, height, o, d)?;
                let t = side.max(end);
                if !(t > 0.0 && t <= leave) {
                    return None;
                }
                let normal = if side > end {
                    ((oxy + dxy * t) / radius).extend(0.0)
                } else {
                    DVec3::new(0.0, 0.0, -d.z.signum())
                };
                Some(Hit { t, normal })
            }
            Self::Wire { from, to, radius } => {
                let length = from.distance(to);
                let axis = (to - from) / length;
                let o = origin - from;
                let across = direction - axis * direction.dot(axis);
                let o_across = o - axis * o.dot(axis);
                let c = o_across.dot(o_across) - radius * radius;
                let t = nearer_root(across.dot(across), o_across.dot(across), c)?;
                let along = (o + direction * t).dot(axis);
                let normal = (o_across + across * t) / radius;
                (along >= 0.0 && along <= length).then_some(Hit { t, normal })
            }
            Self::Leaf { center, axes, radii } => {
                // There are many, and most rays miss the ball around one.
                if !meets_ball(center, radii.x, origin, direction) {
                    return None;
                }
                let turned = axes.transpose();
                let upright = Self::Ellipsoid { center: DVec3::ZERO, radii };
                let hit = upright.enter(turned * (origin - center), turned * direction)?;
                Some(Hit { normal: axes * hit.normal, ..hit })
            }
            Self::Gable { base, half, height, turn } => {
                let (o, d) = (into_block(origin - base, turn), into_block(direction, turn));
                let ([t, leave], normal) = gable(half, height, o, d);
                let normal = into_block(normal.normalize(), DVec2::new(turn.x, -turn.y));
                (t > 0.0 && t <= leave).then_some(Hit { t, normal })
            }
            Self::Ground { height } => {
                let t = (height - origin.z) / direction.z;
                (direction.z < 0.0 && t > 0.0).then_some(Hit { t, normal: DVec3::Z })
            }
        }
    }

    /// Distances along the line at which it enters and leaves; behind the origin they are
    /// negative. `None` where it passes by, and for wires and the ground, which are open.
    pub(super) fn span(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let [from, to] = match *self {
            Self::Ellipsoid { center, radii } => {
                let (o, d) = ((origin - center) / radii, direction / radii);
                roots(d.dot(d), o.dot(d), o.dot(o) - 1.0)?
            }
            Self::Block { center, half, turn } => {
                let o = into_block(origin - center, turn);
                let [enter, leave] = slabs(half, o, into_block(direction, turn));
                [enter.max_element(), leave.min_element()]
            }
            Self::Cylinder { base, radius, height } => {
                let [side, end, leave] = cylinder(radius, height, origin - base, direction)?;
                [side.max(end), leave]
            }
            Self::Leaf { center, axes, radii } => {
                let turned = axes.transpose();
                let upright = Self::Ellipsoid { center: DVec3::ZERO, radii };
                upright.span(turned * (origin - center), turned * direction)?
            }
            Self::Gable { base, half, height, turn } => {
                let (o, d) = (into_block(origin - base, turn), into_block(direction, turn));
                gable(half, height, o, d).0
            }
            Self::Wire { .. } | Self::Ground { .. } => return None,
        };
        (from < to).then_some([from, to])
    }

    /// Centre and radius of a ball around part `part` of [`Self::parts`].
    pub(super) fn bound(&self, part: u32) -> (DVec3, f64) {
        match *self {
            Self::Ellipsoid { center, radii } | Self::Leaf { center, radii, .. } => {
                (center, radii.max_element())
            }
            Self::Block { center, half, .. } => (center, half.length()),
            Self::Cylinder { base, radius, height } => {
                let half = 0.5 * height;
                (base + DVec3::new(0.0, 0.0, half), (radius * radius + half * half).sqrt())
            }
            Self::Wire { from, to, radius } => {
                let piece = (to - from) / f64::from(self.parts());
                (from + piece * (f64::from(part) + 0.5), 0.5 * piece.length() + radius)
            }
            Self::Gable { base, half, height, .. } => (base, half.length().max(height)),
            Self::Ground { .. } => (DVec3::ZERO, f64::INFINITY),
        }
    }

    /// How many balls bound the solid: a row of small ones fits a wire best.
    pub(super) fn parts(&self) -> u32 {
        if matches!(self, Self::Wire { .. }) { 12 } else { 1 }
    }
}

/// Whether a ball reaches the ray from `origin` along the unit vector `direction`.
pub(super) fn meets_ball(center: DVec3, radius: f64, origin: DVec3, direction: DVec3) -> bool {
    let v = center - origin;
    let along = v.dot(direction);
    along > -radius && v.dot(v) - along * along < radius * radius
}

/// The smaller solution of a t² + 2 b t + c = 0, if it is real and positive.
fn nearer_root(a: f64, b: f64, c: f64) -> Option<f64> {
    roots(a, b, c).map(|[t, _]| t).filter(|t| *t > 0.0)
}

/// Both solutions of a t² + 2 b t + c = 0, the smaller one first, if they are real.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - a * c;
    if discriminant <= 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    Some([(-b - root) / a, (root - b) / a])
}

/// Where a line enters the round side of a cylinder on the origin, where it enters the space
/// between its ends, and where it leaves one of them.
fn cylinder(radius: f64, height: f64, o: DVec3, d: DVec3) -> Option<[f64; 3]> {
    let (middle, reach) = ((0.5 * height - o.z) / d.z, (0.5 * height / d.z).abs());
    let (oxy, dxy) = (o.truncate(), d.truncate());
    let [side, far] = roots(dxy.dot(dxy), oxy.dot(dxy), oxy.dot(oxy) - radius * radius)?;
    Some([side, middle - reach, far.min(middle + reach)])
}

/// Where a line enters and leaves the three pairs of planes at ±`half`.
fn slabs(half: DVec3, o: DVec3, d: DVec3) -> [DVec3; 2] {
    let middle = -o / d;
    let reach = (half / d).abs();
    [middle - reach, middle + reach]
}

/// Where a line enters and leaves a roof whose ridge runs along x above the origin, and the
/// outward normal (of any length) where it enters.
fn gable(half: DVec2, height: f64, o: DVec3, d: DVec3) -> ([f64; 2], DVec3) {
    let slope = |side: f64| (DVec3::new(0.0, side / half.y, 1.0 / height), 1.0);
    let sides =
        [(DVec3::X, half.x), (-DVec3::X, half.x), (-DVec3::Z, 0.0), slope(1.0), slope(-1.0)];
    let (mut enter, mut leave, mut normal) = (f64::NEG_INFINITY, f64::INFINITY, DVec3::Z);
    for (outward, limit) in sides {
        let (along, room) = (outward.dot(d), limit - outward.dot(o));
        if along > 0.0 {
            leave = leave.min(room / along);
        } else if along < 0.0 && room / along > enter {
            (enter, normal) = (room / along, outward);
        } else if along == 0.0 && room < 0.0 {
            leave = f64::NEG_INFINITY;
        }
    }
    ([enter, leave], normal)
}

/// `v` in the axes of a block whose x axis is `turn`.
fn into_block(v: DVec3, turn: DVec2) -> DVec3 {
    DVec3::new(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z)
}
