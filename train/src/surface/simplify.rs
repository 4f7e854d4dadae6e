//! Fewer triangles: edges are collapsed, first those whose collapse moves the surface least
//! (Garland and Heckbert, "Surface simplification using quadric error metrics", 1997).

use meshopt::SimplifyOptions;

use super::mesh::Mesh;

impl Mesh {
    /// Leaves at most so many triangles. What is closed stays closed; small parts vanish before
    /// large ones change much, but something is left: where that takes more triangles, these.
    /// Vertices move to where they are nearest to the surface that was there.
    pub fn simplify(&mut self, triangles: usize) {
        let mut most = triangles.max(1);
        while self.triangles.len() > most {
            let (mut corners, mut positions) =
                (self.triangles.as_flattened().to_vec(), self.positions.clone());
            let kept = meshopt::simplify_with_update(
                &mut corners,
                &mut positions,
                &mut [],
                &[],
                0,
                None,
                3 * most,
                f32::MAX,
                SimplifyOptions::None,
                None,
            );
            if kept > 0 {
                self.triangles = corners[..kept].as_chunks().0.to_vec();
                self.positions = positions;
                self.drop_unused();
                return;
            }
            most *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::surface::shapes::{ball, is_closed, strip};

    #[test]
    fn a_ball_stays_round_and_closed() {
        let mut mesh = ball(4);
        assert_eq!(mesh.triangles.len(), 8 * 256);
        mesh.simplify(200);
        assert!((150..=200).contains(&mesh.triangles.len()), "{}", mesh.triangles.len());
        assert!(is_closed(&mesh));
        // Of 200 equal triangles on the ball, each has an area of 4 pi / 200, a side of 0.38 and a middle
        // 0.025 below the ball: a side of sqrt(4 area / sqrt(3)), corners side / sqrt(3) from the
        // middle. Ours differ in size by about two.
        let depth = |p: Vec3| (p.length() - 1.0).abs();
        for triangle in &mesh.triangles {
            let [a, b, c] = mesh.corners(*triangle);
            assert!(depth((a + b + c) / 3.0) < 0.05 && depth(a) < 0.05, "{a} {b} {c}");
            // None is folded over.
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0, "{a} {b} {c}");
        }
    }

    #[test]
    fn a_flat_square_needs_two_triangles() {
        let mut mesh = strip(8, 8, |x, y| Vec3::new(x, y, 1.0));
        mesh.simplify(2);
        assert_eq!((mesh.triangles.len(), mesh.area()), (2, 64.0));
        assert_eq!(mesh.bounds(), Some([[0.0, 0.0, 1.0], [8.0, 8.0, 1.0]]));
    }

    #[test]
    fn something_is_left() {
        let mut mesh = ball(2);
        mesh.simplify(1);
        assert!(!mesh.triangles.is_empty() && is_closed(&mesh), "{:?}", mesh.triangles);
        let before = mesh.clone();
        mesh.simplify(1000);
        assert_eq!(mesh, before);
    }
}
