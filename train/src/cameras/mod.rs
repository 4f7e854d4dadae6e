//! Cameras to render from: circles, single poses and camera paths.

mod every_few;
mod gap;
pub(crate) mod mount;
mod pace;
mod path;
mod spacing;
mod sphere;
mod subject;
mod tour;

use std::f32::consts::TAU;
use std::path::{Path, PathBuf};

use pocketnerf_core::camera::Orbit;
use pocketnerf_core::space::Ndc;
use pocketnerf_core::{Camera, Space};

pub(crate) use every_few::EveryFew;
pub use gap::{GAP, widest_gap};
pub use pace::Pace;
pub use path::{CameraPath, Wanted, camera_path};
pub use spacing::{WIDE, spacing};
pub use sphere::sphere;
pub use subject::nearest_to_axes;
pub(crate) use subject::{cube, distances, object_box};
pub use tour::tour;

use crate::json::{self, JsonError, one_line};
use crate::pose::{self, PoseProblem};

/// Why cameras were refused. Each message is one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// The text is wrong.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// A pose is wrong.
    #[error("{}: camera {camera}: {problem}", one_line(.file))]
    Pose {
        /// The file.
        file: PathBuf,
        /// The camera's place in the list, from 0.
        camera: usize,
        /// What is wrong.
        problem: PoseProblem,
    },
    /// Neither kind of file.
    #[error(
        "{}: no camera path: none of \"camera_path\" and \"keyframes\" (nerfstudio), \"path\" (instant-ngp) and \"frames\" (transforms.json); give one of these",
        one_line(.0)
    )]
    NotAPath(PathBuf),
    /// A list without cameras.
    #[error("{}: no cameras in it, expected at least one", one_line(.0))]
    Empty(PathBuf),
    /// A path that lasts for no time, or for days.
    #[error("{}: {found} each, expected some time, and at most 108,000 pictures", one_line(.file))]
    Timing {
        /// The file.
        file: PathBuf,
        /// What was found.
        found: String,
    },
    /// A lens that cannot be rendered.
    #[error("{}: camera type \"{}\", expected perspective", one_line(.file), json::escape(.found))]
    Lens {
        /// The file.
        file: PathBuf,
        /// What was found.
        found: String,
    },
    /// A field of view that is missing or that no camera has.
    #[error("{}: camera {camera}: field of view {found}, expected {expected}", one_line(.file))]
    FieldOfView {
        /// The file.
        file: PathBuf,
        /// The camera's place in the list, from 0.
        camera: usize,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// No picture size, or one that cannot be.
    #[error("{}: picture size {found}, expected 1x1 to 65536x65536; give --width and --height", one_line(.file))]
    Size {
        /// The file.
        file: PathBuf,
        /// What was found.
        found: String,
    },
}

/// Cameras on a circle, all looking at one point of its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// How many cameras, evenly spaced.
    pub views: usize,
    /// Where the first camera is; the others are further around.
    pub first: Orbit,
    /// Horizontal field of view, radians.
    pub fov_x: f32,
    /// Picture width and height in pixels.
    pub size: [u32; 2],
    /// The azimuths of the first camera and the last, radians; `None`: all the way around.
    pub arc: Option<[f32; 2]>,
    /// The elevation of the last camera, radians, to which the others rise from that of the first:
    /// over several turns, a spiral. `None`: all are as high.
    pub rise: Option<f32>,
    /// How fast they pass.
    pub pace: Pace,
}

impl Circle {
    /// Around the middle of a space, as far from it as the model's own camera, or
    /// at twice the longest side; where the space has no end, as far as its cameras were.
    ///
    /// In front of a forward-facing capture, a circle within the place where its
    /// cameras stood, which looks at what is four times as far away as the near plane.
    #[must_use]
    pub fn around(space: &Space, own: Option<&Camera>, views: usize, fov_x: f32) -> Self {
        let size = own.map_or([400; 2], |c| [c.width, c.height]);
        if let Space::Ndc(ndc) = space {
            return Self { views, fov_x, size, ..Self::before(ndc) };
        }
        let target = space.center();
        let distance =
            |c: &Camera| (0..3).map(|a| (c.position()[a] - target[a]).powi(2)).sum::<f32>().sqrt();
        let first = Orbit {
            target,
            radius: own.map_or(space.viewing_distance(), distance),
            azimuth: 0.0,
            elevation: 0.5,
            axis: [0.0, 0.0, 1.0],
            up: [0.0, 0.0, 1.0],
        };
        Self { views, first, fov_x, size, arc: None, rise: None, pace: Pace::Even }
    }

    /// A circle in the plane z = 0. The box is wider than what one camera at the origin sees by how
    /// far the others stood from it.
    fn before(ndc: &Ndc) -> Self {
        let middle = |a: usize| 0.5 * (ndc.min[a] + ndc.max[a]) * ndc.near / ndc.slope[a];
        let [x, y] = [middle(0), middle(1)];
        let distance = 4.0 * ndc.near;
        let aside = (0.5 * (ndc.max[0] - ndc.min[0]) - 1.0) * ndc.near / ndc.slope[0];
        let aside = (0.5 * aside).clamp(0.05 * ndc.near, 0.25 * ndc.near);
        let first = Orbit {
            target: [x, y, -distance],
            radius: distance.hypot(aside),
            azimuth: 0.0,
            elevation: distance.atan2(aside),
            axis: [0.0, 0.0, 1.0],
            up: [0.0, 1.0, 0.0],
        };
        Self {
            views: 1,
            first,
            fov_x: 2.0 * (1.0 / ndc.slope[0]).atan(),
            size: [400; 2],
            arc: None,
            rise: None,
            pace: Pace::Even,
        }
    }

    /// The horizontal field of view of a model's own camera, radians.
    #[must_use]
    pub fn fov_x(own: Option<&Camera>) -> f32 {
        own.map_or(0.7, |c| 2.0 * (0.5 * c.width as f32 / c.focal[0]).atan())
    }

    /// The cameras, counter-clockwise seen from where the axis points.
    #[must_use]
    pub fn cameras(&self) -> Vec<Camera> {
        let camera = |view: usize| {
            let passed = |n: usize| self.pace.at(view as f32 / n as f32);
            let to_the_last = passed(self.views.saturating_sub(1).max(1));
            let azimuth = match self.arc {
                Some([from, to]) => from + (to - from) * to_the_last,
                None => self.first.azimuth + TAU * passed(self.views),
            };
            let (from, to) = (self.first.elevation, self.rise.unwrap_or(self.first.elevation));
            let elevation = from + (to - from) * to_the_last;
            let pose = Orbit { azimuth, elevation, ..self.first }.pose();
            Camera::from_fov_x(self.size[0], self.size[1], self.fov_x, pose)
        };
        (0..self.views).map(camera).collect()
    }
}

/// A camera-to-world pose from JSON text, or from the file that `json` names:
/// 16 numbers row after row, or 4 rows of 4.
///
/// # Errors
/// One line: the file, what was found and what was expected.
pub fn pose(json: &str) -> Result<[f32; 16], CameraError> {
    const EXPECTED: &str = "a camera-to-world pose: 16 numbers row after row, or 4 rows of 4";
    let inline = json.trim_start().starts_with(['[', '{']);
    let file = Path::new(if inline { "--pose" } else { json });
    let text = if inline { json.as_bytes().to_owned() } else { json::read(file)? };
    let nested = text.iter().filter(|byte| !byte.is_ascii_whitespace()).nth(1) == Some(&b'[');
    let result = if nested {
        pose::from_rows(&json::parse::<Vec<Vec<f64>>>(&text, file, EXPECTED)?)
    } else {
        pose::from_list(&json::parse::<Vec<f64>>(&text, file, EXPECTED)?)
    };
    result.map_err(|problem| CameraError::Pose { file: file.to_owned(), camera: 0, problem })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: &[f32], b: &[f32]) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
    }

    #[test]
    fn an_orbit_of_four() {
        let first = Orbit {
            target: [1.0, 2.0, 3.0],
            radius: 2.0,
            azimuth: 0.0,
            elevation: std::f32::consts::FRAC_PI_6,
            axis: [0.0, 0.0, 2.0],
            up: [0.0, 0.0, 5.0],
        };
        let fov_x = std::f32::consts::FRAC_PI_2;
        let circle = Circle {
            rise: None,
            pace: Pace::Even,
            views: 4,
            first,
            fov_x,
            size: [8, 6],
            arc: None,
        };
        let cameras = circle.cameras();
        // 30° up at distance 2: 1 above, √3 aside.
        let side = 3.0f32.sqrt();
        let expected = [[1.0 + side, 2.0], [1.0, 2.0 + side], [1.0 - side, 2.0], [1.0, 2.0 - side]];
        for (camera, [x, y]) in cameras.iter().zip(expected) {
            assert!(near(&camera.position(), &[x, y, 4.0]), "{:?}", camera.position());
            let ray = camera.ray(4.0, 3.0);
            let end: Vec<f32> =
                ray.origin.iter().zip(ray.direction).map(|(o, d)| o + 2.0 * d).collect();
            assert!(near(&end, &first.target), "{end:?}");
            // 90° wide, 8 pixels: focal 4.
            assert!(near(&camera.focal, &[4.0, 4.0]));
        }
        // From 90° to 270°, both ends included.
        let arc = Some([std::f32::consts::FRAC_PI_2, 3.0 * std::f32::consts::FRAC_PI_2]);
        let part = Circle { views: 3, arc, ..circle }.cameras();
        for (camera, [x, y]) in part.iter().zip(&expected[1..]) {
            assert!(near(&camera.position(), &[*x, *y, 4.0]), "{:?}", camera.position());
        }
        // Two turns, from 30° below to 30° above; slowly at both ends.
        let (down, up) = (-first.elevation, first.elevation);
        let spiral = Circle {
            views: 5,
            first: Orbit { elevation: down, ..first },
            arc: Some([0.0, 2.0 * TAU]),
            rise: Some(up),
            ..circle
        };
        let heights = |circle: Circle| circle.cameras().iter().map(|c| c.position()[2]).collect();
        let [even, eased]: [Vec<f32>; 2] =
            [Pace::Even, Pace::Eased].map(|pace| heights(Circle { pace, ..spiral }));
        // 0, 1/4, 1/2 ... of 60 degrees; eased, 5/32 instead of 1/4.
        let height = |share: f32| 3.0 + 2.0 * (down + 2.0 * up * share).sin();
        assert!(near(&even, &[0.0, 0.25, 0.5, 0.75, 1.0].map(height)), "{even:?}");
        assert!(near(&eased, &[0.0, 0.15625, 0.5, 0.84375, 1.0].map(height)), "{eased:?}");
        // A whole turn between the first, the third and the last: they are on one side.
        let sides = spiral.cameras();
        assert!([0, 2, 4].iter().all(|i| sides[*i].position()[0] > 2.0), "{sides:?}");
        // The first camera's right is +y, its up leans back from +z.
        let m = cameras[0].camera_to_world;
        assert!(near(&[m[0], m[4], m[8]], &[0.0, 1.0, 0.0]), "{m:?}");
        assert!(near(&[m[1], m[5], m[9]], &[-0.5, 0.0, side / 2.0]), "{m:?}");
    }

    #[test]
    fn a_circle_before_a_forward_facing_capture() {
        // Cameras stood up to 0.4 to both sides of x = 0.1, the near plane at 2: the box
        // is as wide as 2 and 0.4 times 2 * 1.5 / 2, around 0.1 * 1.5 / 2.
        let (min, max) = ([0.075 - 1.3, -1.0, -1.0], [0.075 + 1.3, 1.0, 1.0]);
        let space = Space::Ndc(Ndc { near: 2.0, slope: [1.5, 2.0], min, max });
        let cameras = Circle::around(&space, None, 4, 0.7).cameras();
        for (camera, [x, y]) in
            cameras.iter().zip([[0.3, 0.0], [0.1, 0.2], [-0.1, 0.0], [0.1, -0.2]])
        {
            assert!(near(&camera.position(), &[x, y, 0.0]), "{:?}", camera.position());
            assert!(near(&camera.project([0.1, 0.0, -8.0]).unwrap(), &[200.0; 2]));
            // Upright.
            assert!(camera.camera_to_world[5] > 0.99 && camera.camera_to_world[1].abs() < 1e-6);
        }
    }

    #[test]
    fn poses_inline_and_from_a_file() {
        let flat = "[1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1]";
        let rows = " [[1,0,0,5],\n [0,1,0,6], [0,0,1,7], [0,0,0,1]]";
        let expected = [1., 0., 0., 5., 0., 1., 0., 6., 0., 0., 1., 7., 0., 0., 0., 1.];
        assert_eq!(pose(flat).unwrap(), expected);
        assert_eq!(pose(rows).unwrap(), expected);
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), rows).unwrap();
        assert_eq!(pose(file.path().to_str().unwrap()).unwrap(), expected);
    }

    #[test]
    fn poses_that_are_none() {
        for (text, message) in [
            ("[1,2,3]", "--pose: camera 0: the pose has 3 numbers, expected 16 (camera-to-world)"),
            ("[[1,2],[3]]", "--pose: camera 0: the pose has 2 rows of [2, 1] numbers"),
            ("[1,2", "--pose:1:4: not valid JSON"),
            ("{}", "--pose:1:0: invalid type: map"),
            ("nowhere.json", "nowhere.json: cannot be read"),
        ] {
            let error = pose(text).unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
