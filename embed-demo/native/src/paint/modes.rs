//! What a picture shows.

use pocketnerf_core::{Camera, Space};

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Mode {
    /// The scene.
    #[default]
    #[value(alias = "color")]
    Colour,
    /// Depth: near is red, far is blue.
    Depth,
    /// Surface normals: x, y and z as red, green and blue.
    Normals,
    /// Cells of the occupancy grid.
    Occupancy,
}

impl Mode {
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Colour => "colour",
            Self::Depth => "depth",
            Self::Normals => "normals",
            Self::Occupancy => "occupancy",
        }
    }
}

/// Distances at the ends of the colour map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Distance shown red, scene units.
    pub near: f32,
    /// Distance shown blue; infinite in a forward-facing capture and where a scene has no end:
    /// there colours follow 1 / depth.
    pub far: f32,
}

impl Range {
    /// From the nearest to the farthest point of the occupied box, so colours depend neither
    /// on the tile nor on the size of the picture. Where a scene has no end, from a quarter of
    /// the way that cameras are from its centre.
    #[must_use]
    pub fn seen(camera: &Camera, space: &Space, occupied: [[f32; 3]; 2]) -> Self {
        let without_end = |near| Self { near, far: f32::INFINITY };
        match space {
            Space::Ndc(ndc) => return without_end(ndc.near),
            Space::Contracted(_) => return without_end(0.25 * space.viewing_distance()),
            _ => {}
        }
        let ([min, max], eye) = (occupied, camera.position());
        let length = |d: [f32; 3]| d.iter().map(|v| v * v).sum::<f32>().sqrt();
        let aside = |a: usize| (min[a] - eye[a]).max(eye[a] - max[a]).max(0.0);
        let across = |a: usize| (eye[a] - min[a]).abs().max((max[a] - eye[a]).abs());
        Self { near: length([0, 1, 2].map(aside)), far: length([0, 1, 2].map(across)) }
    }

    /// The colour of a depth.
    #[must_use]
    pub fn color(&self, depth: f32) -> [f32; 3] {
        let nearness = match self.far.is_finite() {
            true => (self.far - depth) / (self.far - self.near).max(f32::MIN_POSITIVE),
            false => self.near / depth,
        };
        // The ends of the map are too dark.
        turbo(0.05 + 0.9 * nearness.clamp(0.0, 1.0))
    }
}

/// The colour map Turbo (Mikhailov 2019), by its polynomial.
fn turbo(x: f32) -> [f32; 3] {
    const RED: [f32; 6] = [0.13572, 4.61539, -42.66032, 132.13108, -152.94239, 59.28638];
    const GREEN: [f32; 6] = [0.09140, 2.19419, 4.84297, -14.18503, 4.27730, 2.82957];
    const BLUE: [f32; 6] = [0.10667, 12.64195, -60.58205, 110.36277, -89.90311, 27.34825];
    [RED, GREEN, BLUE].map(|c| c.iter().rev().fold(0.0, |sum, c| sum * x + c).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pocketnerf_core::space::Contracted;

    #[test]
    fn ranges_reach_from_the_nearest_point_to_the_farthest() {
        let space = Space::Box { min: [-9.0; 3], max: [9.0; 3] };
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(8, 8, 1.0, pose);
        let range = Range::seen(&camera, &space, [[-1.0, -2.0, -2.0], [1.0, 2.0, 2.0]]);
        assert_eq!(range.near, 3.0);
        assert!((range.far - 33f32.sqrt()).abs() < 1e-6);
        let inside = Range::seen(&camera, &space, [[-8.0; 3], [8.0; 3]]);
        assert_eq!(inside.near, 0.0);
        let space = Space::Contracted(Contracted { center: [1.0; 3], radius: 8.0 });
        let endless = Range { near: 2.0, far: f32::INFINITY };
        assert_eq!(Range::seen(&camera, &space, space.bounds()), endless);
    }

    #[test]
    fn near_is_red_and_far_is_blue() {
        let range = Range { near: 2.0, far: 6.0 };
        let [r, g, b] = range.color(1.0);
        assert!(r > 0.6 && g < 0.2 && b < 0.1);
        let [r, _, b] = range.color(7.0);
        assert!(r < 0.3 && b > 0.4);
        let [r, g, b] = range.color(4.0);
        assert!(g > 0.9 && r < g && b < g);
        // Twice as far as the nearest: in the middle.
        assert_eq!(Range { near: 1.0, far: f32::INFINITY }.color(2.0), range.color(4.0));
        assert_eq!(range.color(f32::NAN).len(), 3);
    }
}
