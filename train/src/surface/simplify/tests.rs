use glam::{Vec2, Vec3};

use crate::surface::Mesh;
use crate::surface::shapes::{ball, is_closed, mesh, strip};

#[test]
fn a_ball_stays_round_and_closed() {
    let mut mesh = ball(4);
    assert_eq!(mesh.triangles.len(), 8 * 256);
    mesh.simplify(200);
    assert_eq!(mesh.triangles.len(), 200);
    assert!(is_closed(&mesh));
    // Of 200 equal triangles on the ball, each has an area of 4 pi / 200 and a middle 0.025 below it:
    // a side of sqrt(4 area / sqrt(3)) = 0.38, and corners side / sqrt(3) = 0.22 from the middle.
    // Ours differ in size by about two.
    let depth = |p: Vec3| (p.length() - 1.0).abs();
    for triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(*triangle);
        assert!(depth((a + b + c) / 3.0) < 0.05 && depth(a) < 0.05, "{a} {b} {c}");
        // None is turned over.
        assert!((b - a).cross(c - a).dot(a + b + c) > 0.0, "{a} {b} {c}");
    }
}

#[test]
fn a_flat_square_needs_two_triangles() {
    let mut mesh = strip(8, 8, |x, y| Vec3::new(x, y, 1.0));
    mesh.simplify(2);
    assert_eq!(mesh.triangles.len(), 2);
    assert!((mesh.area() - 64.0).abs() < 0.01, "{}", mesh.area());
    for p in &mesh.positions {
        let away = |x: f32| x.abs().min((x - 8.0).abs());
        assert!(away(p[0]) < 1e-3 && away(p[1]) < 1e-3 && (p[2] - 1.0).abs() < 1e-6, "{p:?}");
    }
}

#[test]
fn an_edge_stays_sharp() {
    // A roof of two slopes that meet at x = 4.
    let height = |x: f32| 4.0 - (x - 4.0).abs();
    let mut mesh = strip(8, 8, |x, y| Vec3::new(x, y, height(x)));
    mesh.simplify(4);
    assert_eq!(mesh.triangles.len(), 4);
    assert!(mesh.positions.iter().all(|[x, _, z]| (height(*x) - z).abs() < 1e-3), "{mesh:?}");
    assert!((mesh.area() - 64.0 * 2_f64.sqrt()).abs() < 0.01, "{}", mesh.area());
}

#[test]
fn parts_and_holes_stay() {
    // Two tetrahedra are left of two balls.
    let mut two = ball(2);
    let far = |p: &[f32; 3]| [p[0] + 5.0, p[1], p[2]];
    let n = two.positions.len() as u32;
    let (positions, triangles) = (two.positions.clone(), two.triangles.clone());
    two.positions.extend(positions.iter().map(far));
    two.normals.extend_from_within(..);
    two.colors.extend_from_within(..);
    two.triangles.extend(triangles.iter().map(|triangle| triangle.map(|vertex| vertex + n)));
    two.simplify(1);
    assert_eq!((two.triangles.len(), two.positions.len()), (8, 8));
    assert!(is_closed(&two));
    // A ring keeps its hole: as many edges as vertices and triangles (Euler).
    let mut ring = ring(24, 12);
    ring.simplify(1);
    assert!(is_closed(&ring) && ring.triangles.len() < 60, "{}", ring.triangles.len());
    assert_eq!(3 * ring.triangles.len() / 2, ring.positions.len() + ring.triangles.len());
    let before = ring.clone();
    ring.simplify(1000);
    assert_eq!(ring, before);
}

/// A torus of so many squares around it, and around its body.
fn ring(long: u32, wide: u32) -> Mesh {
    let turned = |i: u32, n: u32| Vec2::from_angle(i as f32 / n as f32 * std::f32::consts::TAU);
    let place = |i: u32| {
        let (around, body) = (turned(i / wide, long), turned(i % wide, wide));
        ((1.0 + 0.3 * body.x) * around).extend(0.3 * body.y)
    };
    let places: Vec<Vec3> = (0..long * wide).map(place).collect();
    let square = |i: u32| {
        let at = |along: u32, across: u32| along % long * wide + across % wide;
        let (u, v) = (i / wide, i % wide);
        [[at(u, v), at(u + 1, v), at(u, v + 1)], [at(u, v + 1), at(u + 1, v), at(u + 1, v + 1)]]
    };
    mesh(&places, &places, (0..long * wide).flat_map(square).collect())
}
