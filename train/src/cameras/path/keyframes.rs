//! Cameras between keyframes.

use glam::{Mat4, Quat, Vec3};

/// A camera that a path passes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Keyframe {
    /// Camera-to-world, row after row.
    pub(super) pose: [f32; 16],
    /// Vertical field of view, degrees.
    pub(super) fov_y: f64,
    /// Seconds from this one to the next.
    pub(super) seconds: f64,
}

/// Pose and field of view of each picture of a path through all `keyframes`, so many a second. A
/// cycle returns to the first one, and ends a picture before it.
///
/// Positions are a cubic Hermite spline with the slopes of the parabola through three keyframes;
/// orientations are the same on the sphere, by De Casteljau's construction (Shoemake, "Animating
/// rotation with quaternion curves", 1985). Neither stops at a keyframe.
pub(super) fn between(keyframes: &[Keyframe], is_cycle: bool, fps: f64) -> Vec<([f32; 16], f64)> {
    let stops: Vec<Stop> = stops(keyframes);
    let n = stops.len();
    let is_cycle = is_cycle && n > 1;
    let n_spans = if is_cycle { n } else { n - 1 };
    let spans: Vec<f64> = keyframes[..n_spans].iter().map(|keyframe| keyframe.seconds).collect();
    let total: f64 = spans.iter().sum();
    let pictures = ((total * fps).round() as usize).max(1);
    let last = if is_cycle { pictures } else { (pictures - 1).max(1) };
    let slopes: Vec<Slope> = (0..n).map(|i| slope(&stops, &spans, i, is_cycle)).collect();
    let picture = |i: usize| {
        let mut left = total * i as f64 / last as f64;
        let mut span = 0;
        while span + 1 < n_spans && left >= spans[span] {
            left -= spans[span];
            span += 1;
        }
        if n_spans == 0 {
            return (keyframes[0].pose, keyframes[0].fov_y);
        }
        let (a, b, h) = (span, (span + 1) % n, spans[span]);
        let t = (left / h).clamp(0.0, 1.0);
        let place = place((&stops[a], &slopes[a]), (&stops[b], &slopes[b]), h as f32, t as f32);
        let [fov_a, fov_b] = [a, b].map(|i| keyframes[i].fov_y);
        (place, fov_a + t * (fov_b - fov_a))
    };
    (0..pictures).map(picture).collect()
}

/// Where a camera is and how it is turned.
#[derive(Clone, Copy, Debug)]
struct Stop {
    position: Vec3,
    rotation: Quat,
}

/// How both change, a second; the rotation about the camera's own axes.
#[derive(Clone, Copy, Debug, Default)]
struct Slope {
    velocity: Vec3,
    turn: Vec3,
}

/// Each on the same side of the sphere of rotations as the one before.
fn stops(keyframes: &[Keyframe]) -> Vec<Stop> {
    let mut before: Option<Quat> = None;
    let stop = |keyframe: &Keyframe| {
        let pose = Mat4::from_cols_array(&keyframe.pose).transpose();
        let (_, rotation, position) = pose.to_scale_rotation_translation();
        let rotation = match before {
            Some(before) if before.dot(rotation) < 0.0 => -rotation,
            _ => rotation,
        };
        before = Some(rotation);
        Stop { position, rotation }
    };
    keyframes.iter().map(stop).collect()
}

fn slope(stops: &[Stop], spans: &[f64], i: usize, is_cycle: bool) -> Slope {
    let n = stops.len();
    let over = |span: usize| {
        let (a, b, h) = (&stops[span], &stops[(span + 1) % n], spans[span] as f32);
        let turn = toward(a.rotation, b.rotation);
        (Slope { velocity: (b.position - a.position) / h, turn: turn / h }, h)
    };
    let after = (i < spans.len()).then(|| over(i));
    let before = match i {
        0 => is_cycle.then(|| over(n - 1)),
        _ => Some(over(i - 1)),
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

/// The axis of the shorter turn from one rotation to another, as long as its angle.
fn toward(from: Quat, to: Quat) -> Vec3 {
    let turn = from.inverse() * to;
    if turn.w < 0.0 { -turn } else { turn }.to_scaled_axis()
}

/// The pose at a share `t` of the `h` seconds from one stop to the next.
fn place((a, from): (&Stop, &Slope), (b, to): (&Stop, &Slope), h: f32, t: f32) -> [f32; 16] {
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
    use super::*;

    /// Turned about z by so many degrees.
    fn at(position: [f32; 3], degrees: f32) -> Keyframe {
        let rotation = Quat::from_rotation_z(degrees.to_radians());
        let pose = Mat4::from_rotation_translation(rotation, position.into());
        Keyframe { pose: pose.transpose().to_cols_array(), fov_y: 40.0, seconds: 2.0 }
    }

    fn position(pose: &[f32; 16]) -> Vec3 {
        Vec3::new(pose[3], pose[7], pose[11])
    }

    fn degrees(pose: &[f32; 16]) -> f32 {
        pose[4].atan2(pose[0]).to_degrees()
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
    fn one_keyframe_is_one_picture() {
        let one = at([1.0, 2.0, 3.0], 30.0);
        for is_cycle in [false, true] {
            assert_eq!(between(&[one], is_cycle, 30.0), [(one.pose, 40.0)]);
        }
    }
}
