use super::*;
use crate::Space;

/// Around (1, 0, 0), two scene units to each side.
const SPACE: Contracted = Contracted { center: [1.0, 0.0, 0.0], radius: 2.0 };

fn close(found: [f32; 3], hand: [f32; 3], tolerance: f32) {
    for (a, b) in found.iter().zip(hand) {
        assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{found:?}, by hand {hand:?}");
    }
}

fn at(piece: &Piece, t: f32) -> [f32; 3] {
    let Ray { origin: o, direction: d } = piece.local;
    [0, 1, 2].map(|a| o[a] + t * d[a])
}

#[test]
fn points_by_hand() {
    for (scene, local) in [
        ([2.0, -1.0, 0.5], [0.5, -0.5, 0.25]),
        // Two radii out along x: 2 - 1/2; the others are halved.
        ([5.0, 1.0, -3.0], [1.5, 0.25, -0.75]),
        ([1.0, -8.0, 2.0], [0.0, -1.75, 0.25]),
        ([3.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
    ] {
        close(SPACE.local_point(scene), local, 1e-6);
        close(SPACE.scene_point(local), scene, 1e-6);
    }
    assert!(SPACE.scene_point([2.0, 0.0, 0.0])[0] > 1e6);
    assert_eq!(Space::Contracted(SPACE).center(), [1.0, 0.0, 0.0]);
}

#[test]
fn a_ray_by_hand() {
    // From the centre along (3, 4, 0) / 5: it leaves the cube through y = 1, at (3/4, 1, 0),
    // after 5/4. Beyond it goes straight on to (3/4, 2, 0), which is infinity.
    let ray = Ray { origin: [1.0, 0.0, 0.0], direction: [0.6, 0.8, 0.0] };
    let first = SPACE.piece(&ray, 0.0).unwrap();
    assert!((first.end - 1.25).abs() < 1e-6);
    close(first.local.origin, [0.0; 3], 1e-6);
    close(first.local.direction, ray.direction, 1e-6);
    let second = SPACE.piece(&ray, first.end).unwrap();
    close(second.local.direction, [0.0, 1.0, 0.0], 1e-6);
    close(at(&second, 1.25), [0.75, 1.0, 0.0], 1e-6);
    assert!((second.end - 2.25).abs() < 2e-5 && second.end < 2.25);
    assert_eq!(SPACE.piece(&ray, second.end), None);
    assert!(SPACE.length(&ray) < second.end && SPACE.length(&ray) > 2.2499);
    // Half of the second piece: y = 2 radii, 5/2 radii along the ray, 5 scene units.
    assert!((SPACE.depth(&ray, 1.75) - 5.0).abs() < 1e-4);
    assert!((SPACE.depth(&ray, 1.0) - 2.0).abs() < 1e-6);
    assert!(SPACE.depth(&ray, 2.25) > 1e6);
    assert_eq!(SPACE.depth(&ray, f32::INFINITY), f32::INFINITY);
}

#[test]
fn a_ray_across_all_by_hand() {
    // In radii from (-3, 1/2, 0) along x. Beyond x = -1 first: from -(2 - 1/3) to -1, from
    // y = 1/6 to 1/2; through the cube; and beyond x = 1, to infinity where y is 0.
    let ray = Ray { origin: [-5.0, 1.0, 0.0], direction: [1.0, 0.0, 0.0] };
    let first = SPACE.piece(&ray, 0.0).unwrap();
    let length = (4.0f32 / 9.0 + 1.0 / 9.0).sqrt();
    assert!((first.end - length).abs() < 1e-6);
    close(at(&first, 0.0), [-5.0 / 3.0, 1.0 / 6.0, 0.0], 1e-6);
    close(at(&first, first.end), [-1.0, 0.5, 0.0], 1e-6);
    let second = SPACE.piece(&ray, first.end).unwrap();
    assert!((second.end - length - 2.0).abs() < 1e-6);
    close(at(&second, second.end), [1.0, 0.5, 0.0], 1e-6);
    let third = SPACE.piece(&ray, second.end).unwrap();
    close(at(&third, third.end), [2.0, 0.0, 0.0], 2e-5);
    // 3/4 of the way from 1/3 to 1 in 1/x, that is 1/x = 5/6, x = 6/5: 9/5 radii along.
    assert!((SPACE.depth(&ray, 0.75 * length) - 3.6).abs() < 1e-4);
}

#[test]
fn points_of_pieces_are_those_of_the_scene() {
    let mut seed = 1u32;
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut most = 0;
    for i in 0..2000 {
        let spread = if i % 2 == 0 { 3.0 } else { 20.0 };
        let origin = [0, 1, 2].map(|_| spread * next());
        let way = [next(), next(), if i % 7 == 0 { 0.0 } else { next() }];
        let length = crate::math::sqrt(way.iter().map(|w| w * w).sum());
        let ray = Ray { origin, direction: way.map(|w| w / length) };
        let (mut t, mut last, mut pieces, mut end) = (0.0, -1.0, 0, 0.0);
        while let Some(piece) = SPACE.piece(&ray, t) {
            if piece.end != end {
                (pieces, end) = (pieces + 1, piece.end);
            }
            let depth = SPACE.depth(&ray, t);
            assert!(depth >= last, "{depth} after {last}");
            last = depth;
            let p = at(&piece, t);
            assert!(p.iter().all(|p| p.abs() <= 2.0), "{p:?}");
            if depth < 1e3 {
                let q = [0, 1, 2].map(|a| origin[a] + depth * ray.direction[a]);
                // Where two coordinates are equally large, either may be taken.
                let found = SPACE.scene_point(p);
                close(found, q, 2e-4 * (1.0 + depth));
            }
            t += 0.03;
        }
        most = most.max(pieces);
        assert!(pieces >= 1 && (t - SPACE.length(&ray)).abs() < 0.031);
    }
    assert!(most >= 4, "{most}");
}

#[test]
fn rays_that_are_none() {
    let see = |origin, direction| SPACE.piece(&Ray { origin, direction }, 0.0).is_some();
    assert!(see([0.0; 3], [0.0, 0.0, -1.0]));
    assert!(see([0.0, 1e5, 0.0], [0.0, -1.0, 0.0]));
    assert!(!see([0.0; 3], [0.0; 3]));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let (mut origin, mut direction) = ([0.0; 3], [0.0, 0.0, -1.0]);
            origin[axis] = bad;
            assert!(!see(origin, direction), "{origin:?}");
            direction[axis] = bad;
            assert!(!see([0.0; 3], direction), "{direction:?}");
        }
    }
}

#[test]
fn refuses_what_is_no_such_space() {
    assert_eq!(Space::Contracted(SPACE).validate(), Ok(()));
    for wrong in [
        Contracted { radius: 0.0, ..SPACE },
        Contracted { radius: -1.0, ..SPACE },
        Contracted { radius: f32::NAN, ..SPACE },
        Contracted { center: [0.0, f32::INFINITY, 0.0], ..SPACE },
        Contracted { center: [0.0, 0.0, f32::NAN], ..SPACE },
    ] {
        assert!(matches!(Space::Contracted(wrong).validate(), Err(Error::Range(_))), "{wrong:?}");
    }
}
