//! Smooth paths through keyframes.

use core::ops::Range;

use glam::{Mat4, Quat, Vec3};

/// A camera that a path passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// Camera-to-world, as [`Camera::camera_to_world`](super::Camera::camera_to_world) has it.
    pub pose: [f32; 16],
    /// Vertical field of view, degrees.
    pub fov_y: f64,
    /// Seconds from this one to the next, greater than 0.
    pub seconds: f64,
}

impl Keyframe {
    /// Seconds from one to the next where nothing else is said: nerfstudio's default.
    pub const SECONDS: f64 = 2.0;
}

/// A smooth path through keyframes. What shows it and what renders it later ask here, so they show
/// the same.
///
/// Positions are a cubic Hermite spline with the slopes of the parabola through three keyframes;
/// orientations are the same on the sphere, by De Casteljau's construction (Shoemake, "Animating
/// rotation with quaternion curves", 1985). Neither stops at a keyframe.
///
/// ```
/// use pocketnerf_core::Camera;
/// use pocketnerf_core::camera::{Keyframe, KeyframePath};
///
/// let at = |x| {
///     let pose = Camera::look_at([x, 0.0, 4.0], [x, 0.0, 0.0], [0.0, 1.0, 0.0]);
///     Keyframe { pose, fov_y: 40.0, seconds: 2.0 }
/// };
/// let path = KeyframePath { keyframes: &[at(0.0), at(1.0)], is_cycle: false, fps: 1.5 };
/// // Two seconds: three pictures, the first and the last at the keyframes.
/// let xs: Vec<f32> = path.pictures().map(|(pose, _)| pose[3]).collect();
/// assert_eq!(xs, [0.0, 0.5, 1.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyframePath<'k> {
    /// In the order in which they are passed.
    pub keyframes: &'k [Keyframe],
    /// Whether the path returns to the first one.
    pub is_cycle: bool,
    /// Pictures a second.
    pub fps: f64,
}

impl KeyframePath<'_> {
    /// Pictures a second where nothing else is said.
    pub const FPS: f64 = 30.0;

    /// How long it takes: 0 with fewer than two keyframes.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.keyframes[self.spans()].iter().map(|keyframe| keyframe.seconds).sum()
    }

    /// How many pictures there are: at least one, if there is a keyframe.
    #[must_use]
    pub fn len(&self) -> usize {
        let rounded = (self.seconds() * self.fps + 0.5) as usize;
        if self.is_empty() { 0 } else { rounded.max(1) }
    }

    /// Whether there are no keyframes, and so no pictures.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.keyframes.is_empty()
    }

    /// Pose and vertical field of view, degrees, of each picture. The last one is at the last
    /// keyframe; of a cycle, a picture before it returns to the first.
    pub fn pictures(&self) -> impl ExactSizeIterator<Item = ([f32; 16], f64)> + '_ {
        let (n, seconds) = (self.len(), self.seconds());
        let last = if self.returns() { n } else { n.saturating_sub(1) }.max(1);
        (0..n).map(move |i| self.at(seconds * i as f64 / last as f64))
    }

    /// Pose and vertical field of view at a time in seconds. There is a keyframe.
    fn at(&self, seconds: f64) -> ([f32; 16], f64) {
        let (mut left, mut span) = (seconds, 0);
        let spans = self.spans();
        while span + 1 < spans.end && left >= self.keyframes[span].seconds {
            left -= self.keyframes[span].seconds;
            span += 1;
        }
        let (a, b) = (&self.keyframes[span], &self.keyframes[self.after(span)]);
        if spans.is_empty() {
            return (a.pose, a.fov_y);
        }
        let t = (left / a.seconds).clamp(0.0, 1.0);
        let from = (Stop::of(a), self.slope(span));
        let to = (Stop::of(b), self.slope(self.after(span)));
        (place(from, to, a.seconds as f32, t as f32), a.fov_y + t * (b.fov_y - a.fov_y))
    }

    fn returns(&self) -> bool {
        self.is_cycle && self.keyframes.len() > 1
    }

    /// The keyframes from which there is a way to the next.
    fn spans(&self) -> Range<usize> {
        let n = self.keyframes.len();
        0..if self.returns() { n } else { n.saturating_sub(1) }
    }

    fn after(&self, i: usize) -> usize {
        (i + 1) % self.keyframes.len()
    }

    /// How the camera moves as it passes a keyframe.
    fn slope(&self, i: usize) -> Slope {
        let after = self.spans().contains(&i).then(|| self.way(i));
        let before = match i {
            0 => self.returns().then(|| self.way(self.keyframes.len() - 1)),
            _ => Some(self.way(i - 1)),
        };
        match (before, after) {
            (Some((before, h0)), Some((after, h1))) => {
                // Of the parabola through the three.
                let mean = |before: Vec3, after: Vec3| (h1 * before + h0 * after) / (h0 + h1);
                Slope {
                    velocity: mean(before.velocity, after.velocity),
                    turn: mean(before.turn, after.turn),
                }
            }
            (one, other) => one.or(other).map_or_else(Slope::default, |(slope, _)| slope),
        }
    }

    /// The straight way from a keyframe to the next, and its seconds.
    fn way(&self, i: usize) -> (Slope, f32) {
        let [a, b] = [i, self.after(i)].map(|i| Stop::of(&self.keyframes[i]));
        let h = self.keyframes[i].seconds as f32;
        let turn = toward(a.rotation, b.rotation);
        (Slope { velocity: (b.position - a.position) / h, turn: turn / h }, h)
    }
}

/// Where a camera is and how it is turned.
#[derive(Clone, Copy, Debug)]
struct Stop {
    position: Vec3,
    rotation: Quat,
}

impl Stop {
    fn of(keyframe: &Keyframe) -> Self {
        let pose = Mat4::from_cols_array(&keyframe.pose).transpose();
        let (_, rotation, position) = pose.to_scale_rotation_translation();
        Self { position, rotation }
    }
}

/// How both change, a second; the rotation about the camera's own axes.
#[derive(Clone, Copy, Debug, Default)]
struct Slope {
    velocity: Vec3,
    turn: Vec3,
}

/// The axis of the shorter turn from one rotation to another, as long as its angle.
fn toward(from: Quat, to: Quat) -> Vec3 {
    let turn = from.inverse() * to;
    if turn.w < 0.0 { -turn } else { turn }.to_scaled_axis()
}

/// The pose at a share `t` of the `h` seconds from one stop to the next.
fn place((a, from): (Stop, Slope), (b, to): (Stop, Slope), h: f32, t: f32) -> [f32; 16] {
    let third = h / 3.0;
    let points = [
        a.position,
        a.position + third * from.velocity,
        b.position - third * to.velocity,
        b.position,
    ];
    let turned = |rotation: Quat, turn: Vec3| rotation * Quat::from_scaled_axis(third * turn);
    let rotations =
        [a.rotation, turned(a.rotation, from.turn), turned(b.rotation, -to.turn), b.rotation];
    let position = de_casteljau(points, |a, b| a.lerp(b, t));
    // The shorter way, whatever the signs.
    let rotation = de_casteljau(rotations, |a, b| a.slerp(b, t)).normalize();
    Mat4::from_rotation_translation(rotation, position).transpose().to_cols_array()
}

/// A point of a Bézier curve, by mixing neighbours until one is left.
fn de_casteljau<T: Copy>([a, b, c, d]: [T; 4], mix: impl Fn(T, T) -> T) -> T {
    let [ab, bc, cd] = [mix(a, b), mix(b, c), mix(c, d)];
    mix(mix(ab, bc), mix(bc, cd))
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;

    /// Turned about z by so many degrees.
    fn at(position: [f32; 3], degrees: f32) -> Keyframe {
        let rotation = Quat::from_rotation_z(degrees.to_radians());
        let pose = Mat4::from_rotation_translation(rotation, position.into());
        Keyframe { pose: pose.transpose().to_cols_array(), fov_y: 40.0, seconds: 2.0 }
    }

    fn between(keyframes: &[Keyframe], is_cycle: bool, fps: f64) -> Vec<([f32; 16], f64)> {
        KeyframePath { keyframes, is_cycle, fps }.pictures().collect()
    }

    fn position(pose: &[f32; 16]) -> Vec3 {
        Vec3::new(pose[3], pose[7], pose[11])
    }

    fn degrees(pose: &[f32; 16]) -> f32 {
        f32::atan2(pose[4], pose[0]).to_degrees()
    }

    #[test]
    fn a_straight_line_at_an_even_pace() {
        let keyframes = [0.0, 1.0, 2.0, 3.0].map(|x| at([x, 2.0 * x, 0.0], 60.0 * x));
        let path = between(&keyframes, false, 5.0);
        assert_eq!(path.len(), 30);
        for (i, (pose, fov)) in path.iter().enumerate() {
            let x = 3.0 * i as f32 / 29.0;
            assert!((position(pose) - Vec3::new(x, 2.0 * x, 0.0)).length() < 1e-5, "{i}: {pose:?}");
            // From 0 to 180 degrees, past which the angle is told from below.
            assert!((degrees(pose) - 60.0 * x).abs() % 360.0 < 0.1, "{i}: {}", degrees(pose));
            assert_eq!(*fov, 40.0);
        }
    }

    #[test]
    fn keyframes_are_passed_when_their_time_comes_and_without_a_stop() {
        let mut keyframes =
            [at([0.0; 3], 0.0), at([1.0, 1.0, 0.0], 80.0), at([2.0, 0.0, 0.0], 0.0)];
        keyframes[0].seconds = 1.0;
        keyframes[1].fov_y = 60.0;
        // A picture each tenth of a second, the last one at 3 seconds.
        let path = between(&keyframes, false, 31.0 / 3.0);
        assert_eq!(path.len(), 31);
        for (i, expected) in [(0, &keyframes[0]), (10, &keyframes[1]), (30, &keyframes[2])] {
            let (pose, fov) = &path[i];
            assert!(pose.iter().zip(&expected.pose).all(|(a, b)| (a - b).abs() < 1e-5), "{i}");
            assert!((fov - expected.fov_y).abs() < 1e-9);
        }
        // The parabola through the three in x: 1 unit in one second, 1 in two, hence
        // (2 * 1 + 1 * 0.5) / 3 a second at the middle one.
        let x = |i: usize| position(&path[i].0).x;
        assert!((x(11) - x(9) - 0.2 * 2.5 / 3.0).abs() < 5e-3, "{}", x(11) - x(9));
        // 80 degrees in one second, -80 in two.
        let turned = degrees(&path[11].0) - degrees(&path[9].0);
        assert!((turned - 0.2 * (2.0 * 80.0 - 40.0) / 3.0).abs() < 1.5, "{turned}");
    }

    #[test]
    fn a_cycle_returns_without_showing_its_beginning_twice() {
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let mut turn = 0.0;
        let keyframes = corners.map(|corner| {
            turn += 90.0;
            at(corner, turn)
        });
        let path = between(&keyframes, true, 10.0);
        assert_eq!(path.len(), 80);
        assert!((position(&path[20].0) - Vec3::from(corners[1])).length() < 1e-5);
        // Nearly a circle, at an even pace, the last step too.
        for i in 0..80 {
            let (here, next) = (position(&path[i].0), position(&path[(i + 1) % 80].0));
            // By hand, 0.625 of both axes halfway.
            assert!((0.883..1.001).contains(&here.length()), "{i}: {here}");
            assert!(
                (0.05..0.12).contains(&(next - here).length()),
                "{i}: {}",
                (next - here).length()
            );
            let turned = (degrees(&path[(i + 1) % 80].0) - degrees(&path[i].0)).rem_euclid(360.0);
            assert!((turned - 4.5).abs() < 0.1, "{i}: {turned}");
        }
    }

    #[test]
    fn without_keyframes_there_is_nothing() {
        let path = KeyframePath { keyframes: &[], is_cycle: true, fps: 30.0 };
        assert_eq!((path.len(), path.is_empty(), path.seconds()), (0, true, 0.0));
        assert_eq!(path.pictures().next(), None);
    }

    #[test]
    fn one_keyframe_is_one_picture() {
        let one = at([1.0, 2.0, 3.0], 30.0);
        for is_cycle in [false, true] {
            assert_eq!(between(&[one], is_cycle, 30.0), [(one.pose, 40.0)]);
        }
    }
}
