//! COLMAP's camera models.

use std::f64::consts::PI;

use crate::dataset::intrinsics::Intrinsics;
use crate::lens::Lens;

/// Names and numbers of parameters, in the order of the models' own numbers.
const KINDS: [(&str, usize); 11] = [
    ("SIMPLE_PINHOLE", 3),
    ("PINHOLE", 4),
    ("SIMPLE_RADIAL", 4),
    ("RADIAL", 5),
    ("OPENCV", 8),
    ("OPENCV_FISHEYE", 8),
    ("FULL_OPENCV", 12),
    ("FOV", 5),
    ("SIMPLE_RADIAL_FISHEYE", 4),
    ("RADIAL_FISHEYE", 5),
    ("THIN_PRISM_FISHEYE", 12),
];

/// A camera as a model has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Camera {
    pub(super) intrinsics: Intrinsics,
    pub(super) lens: Lens,
    /// The angle between its axis and its pictures' corners.
    pub(super) half_angle: f64,
}

/// Name and number of parameters of the camera model of that number.
pub(super) fn kind(number: u32) -> Option<(&'static str, usize)> {
    KINDS.get(number as usize).copied()
}

/// Whether there is a camera model of that name.
pub(super) fn is_kind(name: &str) -> bool {
    KINDS.iter().any(|(kind, _)| *kind == name)
}

impl Camera {
    /// A camera of a known model; else what was found and what was expected.
    pub(super) fn new(kind: &str, size: [f64; 2], numbers: &[f64]) -> Result<Self, String> {
        let ([fx, fy, cx, cy], lens) = match (kind, numbers) {
            ("SIMPLE_PINHOLE", &[f, x, y]) => ([f, f, x, y], Lens::Pinhole),
            ("PINHOLE", &[fx, fy, x, y]) => ([fx, fy, x, y], Lens::Pinhole),
            ("SIMPLE_RADIAL", &[f, x, y, k]) => ([f, f, x, y], open_cv([k, 0.0], [0.0; 2])),
            ("RADIAL", &[f, x, y, k1, k2]) => ([f, f, x, y], open_cv([k1, k2], [0.0; 2])),
            ("OPENCV", &[fx, fy, x, y, k1, k2, p1, p2]) => {
                ([fx, fy, x, y], open_cv([k1, k2], [p1, p2]))
            }
            ("OPENCV_FISHEYE", &[fx, fy, x, y, k1, k2, k3, k4]) => {
                ([fx, fy, x, y], Lens::fisheye([k1, k2, k3, k4]))
            }
            ("FULL_OPENCV", &[fx, fy, x, y, k1, k2, p1, p2, k3, k4, k5, k6]) => {
                ([fx, fy, x, y], Lens::full_open_cv([k1, k2, k3, k4, k5, k6], [p1, p2]))
            }
            ("FOV", &[_, _, _, _, omega]) if omega.is_nan() || omega.abs() >= PI => {
                return Err(format!("omega is {omega}, expected radians below pi"));
            }
            ("FOV", &[fx, fy, x, y, omega]) => ([fx, fy, x, y], Lens::fov(omega)),
            ("SIMPLE_RADIAL_FISHEYE", &[f, x, y, k]) => {
                ([f, f, x, y], Lens::fisheye([k, 0.0, 0.0, 0.0]))
            }
            ("RADIAL_FISHEYE", &[f, x, y, k1, k2]) => {
                ([f, f, x, y], Lens::fisheye([k1, k2, 0.0, 0.0]))
            }
            ("THIN_PRISM_FISHEYE", &[fx, fy, x, y, k1, k2, p1, p2, k3, k4, s1, s2]) => {
                ([fx, fy, x, y], Lens::thin_prism_fisheye([k1, k2, k3, k4], [p1, p2], [s1, s2]))
            }
            _ => {
                let expected = KINDS.iter().find(|(name, _)| *name == kind);
                let expected = expected.map_or(0, |(_, count)| *count);
                return Err(format!("{} numbers for {kind}, expected {expected}", numbers.len()));
            }
        };
        let intrinsics = Intrinsics::from_pixels(size, [fx, fy, cx, cy], &lens)?;
        let [width, height] = size;
        let angle = |[x, y]: [f64; 2]| {
            let ([x, y, z], _) = lens.undistort([(x - cx) / fx, (y - cy) / fy]);
            x.hypot(y).atan2(z)
        };
        let corners = [[0.0; 2], [width, 0.0], [0.0, height], size];
        let half_angle = corners.map(angle).into_iter().fold(0.0, f64::max);
        Ok(Self { intrinsics, lens, half_angle })
    }
}

fn open_cv([k1, k2]: [f64; 2], p: [f64; 2]) -> Lens {
    Lens::open_cv([k1, k2, 0.0, 0.0], p)
}
