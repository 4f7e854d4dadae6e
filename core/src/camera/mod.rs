//! Pixel to ray: the pinhole camera.
//!
//! Camera axes are OpenGL's and Blender's: x right, y up, looking along −z.
//! The centre of pixel (0, 0) is at (0.5, 0.5).

mod orbit;
mod path;

use fearless_simd::{Select, Simd, SimdBase, SimdFloat};
use glam::Vec3;

pub use orbit::Orbit;
pub use path::{Keyframe, KeyframePath};

use crate::Error;
use crate::query::is_rotation;

/// A pinhole camera with its pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Focal length in x and y, pixels.
    pub focal: [f32; 2],
    /// Principal point in x and y, pixels from the top left corner.
    pub center: [f32; 2],
    /// 4×4 camera-to-world, row after row as in `transforms.json`: the columns
    /// are right, up, back and the camera's position, in scene units.
    pub camera_to_world: [f32; 16],
}

/// A half line in scene space. In memory it is its six numbers, for hosts that hand over such.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, scene units.
    pub origin: [f32; 3],
    /// Where it goes: a unit vector, so that `t` is a Euclidean distance.
    pub direction: [f32; 3],
}

impl Camera {
    /// A camera with square pixels and a centred principal point.
    /// `fov_x` is the horizontal field of view in radians.
    #[must_use]
    pub fn from_fov_x(width: u32, height: u32, fov_x: f32, camera_to_world: [f32; 16]) -> Self {
        let focal = 0.5 * width as f32 / crate::math::tan(0.5 * fov_x);
        Self {
            width,
            height,
            focal: [focal, focal],
            center: [0.5 * width as f32, 0.5 * height as f32],
            camera_to_world,
        }
    }

    /// The pose of a camera at `eye` that looks at `target` with `up` upwards.
    #[must_use]
    pub fn look_at(eye: [f32; 3], target: [f32; 3], up: [f32; 3]) -> [f32; 16] {
        let (eye, target, up) = (Vec3::from(eye), Vec3::from(target), Vec3::from(up));
        let back = (eye - target).normalize_or(Vec3::Z);
        let side = up.cross(back);
        // Looking straight along `up`: any right vector will do.
        let right = side.normalize_or(back.any_orthonormal_vector());
        let up = back.cross(right);
        [
            right.x, up.x, back.x, eye.x, //
            right.y, up.y, back.y, eye.y, //
            right.z, up.z, back.z, eye.z, //
            0.0, 0.0, 0.0, 1.0,
        ]
    }

    /// Pixels along a side of a picture at most.
    pub const MAX_SIDE: u32 = 1 << 14;

    /// Checks numbers that come from elsewhere: picture size, focal lengths and principal
    /// point, and whether the pose is a rotation and a place. Rendering does not require that: a camera
    /// without sense takes pictures of nothing.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        let Self { width, height, focal, center, camera_to_world: m } = self;
        let fail = |what| Err(Error::Range(what));
        if [width, height].iter().any(|side| !(1..=Self::MAX_SIDE).contains(*side)) {
            return fail("camera: width and height, expected 1 to 16384 pixels");
        }
        if !focal.iter().all(|f| (1e-3..1e9).contains(f)) {
            return fail("camera: focal lengths, expected 0.001 to 1e9 pixels");
        }
        if !center.iter().all(|c| c.abs() < 1e9) {
            return fail("camera: principal point, expected pixels below 1e9");
        }
        if !is_rotation(&[0, 4, 8].map(|row| [m[row], m[row + 1], m[row + 2]])) {
            return fail(
                "camera: pose, expected unit vectors right, up and back, right-handed, in its columns",
            );
        }
        if ![m[3], m[7], m[11]].iter().all(|v| v.abs() <= 1e11) {
            return fail("camera: position, expected finite numbers");
        }
        Ok(())
    }

    /// The camera's position in scene units.
    #[must_use]
    pub fn position(&self) -> [f32; 3] {
        let m = &self.camera_to_world;
        [m[3], m[7], m[11]]
    }

    /// The image point at which the camera sees `p`, pixels from the top left
    /// corner, inside the picture or not; `None` behind the camera.
    #[must_use]
    pub fn project(&self, p: [f32; 3]) -> Option<[f32; 2]> {
        let m = &self.camera_to_world;
        let d = [p[0] - m[3], p[1] - m[7], p[2] - m[11]];
        let along = |c: usize| d[0] * m[c] + d[1] * m[4 + c] + d[2] * m[8 + c];
        let depth = -along(2);
        (depth > 0.0).then(|| {
            [
                self.center[0] + self.focal[0] * along(0) / depth,
                self.center[1] - self.focal[1] * along(1) / depth,
            ]
        })
    }

    /// The ray through the image point (`x`, `y`), pixels from the top left
    /// corner: pixel (i, j) has its centre at (i + 0.5, j + 0.5).
    #[must_use]
    pub fn ray(&self, x: f32, y: f32) -> Ray {
        let m = &self.camera_to_world;
        let cx = (x - self.center[0]) / self.focal[0];
        let cy = -(y - self.center[1]) / self.focal[1];
        let d = Vec3::new(
            m[0] * cx + m[1] * cy - m[2],
            m[4] * cx + m[5] * cy - m[6],
            m[8] * cx + m[9] * cy - m[10],
        );
        Ray { origin: self.position(), direction: d.normalize_or(-Vec3::Z).to_array() }
    }

    /// Where it looks, a unit vector.
    #[must_use]
    pub fn axis(&self) -> [f32; 3] {
        let m = &self.camera_to_world;
        Vec3::new(-m[2], -m[6], -m[10]).normalize_or(-Vec3::Z).to_array()
    }

    /// The directions of the rays through a register of image points, each equal
    /// to that of [`Camera::ray`].
    #[inline(always)]
    pub(crate) fn directions<S: Simd>(&self, simd: S, x: S::f32s, y: S::f32s) -> [S::f32s; 3] {
        let m = &self.camera_to_world;
        let cx = (x - self.center[0]) / self.focal[0];
        let cy = -((y - self.center[1]) / self.focal[1]);
        let along = |row: usize| cx * m[row] + cy * m[row + 1] - m[row + 2];
        let d = [along(0), along(4), along(8)];
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let inverse = S::f32s::splat(simd, 1.0) / length;
        let sound = inverse.is_finite() & inverse.simd_gt(S::f32s::splat(simd, 0.0));
        let or = |value: S::f32s, other: f32| sound.select(value, S::f32s::splat(simd, other));
        [or(d[0] * inverse, -0.0), or(d[1] * inverse, -0.0), or(d[2] * inverse, -1.0)]
    }

    /// The same view with `n` times as many pixels along each side: its rays are `n` × `n` a
    /// pixel, and [`average_tile`](crate::render::average_tile) makes one pixel of them. Smooth
    /// where this camera's pixels are larger than those of the photographs.
    ///
    /// ```
    /// use pocketnerf_core::Camera;
    ///
    /// let pose = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]);
    /// let camera = Camera::from_fov_x(100, 50, 0.7, pose);
    /// // Four rays for the pixel in the corner, around the one through its centre.
    /// let fine = camera.finer(2);
    /// assert_eq!((fine.width, fine.height, fine.center), (200, 100, [100.0, 50.0]));
    /// assert_eq!(fine.ray(1.0, 1.0), camera.ray(0.5, 0.5));
    /// ```
    #[must_use]
    pub fn finer(&self, n: u32) -> Self {
        let scale = n as f32;
        Self {
            width: self.width.saturating_mul(n),
            height: self.height.saturating_mul(n),
            focal: self.focal.map(|f| f * scale),
            center: self.center.map(|c| c * scale),
            camera_to_world: self.camera_to_world,
        }
    }

    /// The same view with `factor` times fewer pixels along each side.
    #[must_use]
    pub fn downscaled(&self, factor: u32) -> Self {
        let width = (self.width / factor).max(1);
        let height = (self.height / factor).max(1);
        let (sx, sy) = (width as f32 / self.width as f32, height as f32 / self.height as f32);
        Self {
            width,
            height,
            focal: [self.focal[0] * sx, self.focal[1] * sy],
            center: [self.center[0] * sx, self.center[1] * sy],
            camera_to_world: self.camera_to_world,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_in_lanes_are_those_of_single_rays() {
        let eye = [1.0, -2.5, 3.0];
        let pose = Camera::look_at(eye, [0.1, 0.2, 0.0], [0.0, 0.0, 1.0]);
        let mut camera = Camera::from_fov_x(37, 23, 0.9, pose);
        for scale in [1.0, 1e-30, 0.0, f32::NAN] {
            camera.camera_to_world = pose.map(|v| v * scale);
            for level in crate::SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok()) {
                fearless_simd::dispatch!(level, simd => same_directions(simd, &camera));
            }
        }
    }

    fn same_directions<S: Simd>(simd: S, camera: &Camera) {
        for i in 0..37 {
            let (x, y) = (i as f32 + 0.5, 22.5 - 0.5 * i as f32);
            let splat = |v: f32| S::f32s::splat(simd, v);
            let lanes = camera.directions(simd, splat(x), splat(y)).map(|d| d.as_slice()[0]);
            assert_eq!(lanes, camera.ray(x, y).direction);
        }
    }

    #[test]
    fn rays_of_a_hand_made_camera() {
        // At (0, 0, 4), looking along −z, 90° wide, 2×2 pixels: focal = 1 pixel.
        let pose = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]);
        let camera = Camera::from_fov_x(2, 2, core::f32::consts::FRAC_PI_2, pose);
        assert!((camera.focal[0] - 1.0).abs() < 1e-6);
        let middle = camera.ray(1.0, 1.0);
        assert_eq!(middle.origin, [0.0, 0.0, 4.0]);
        assert_eq!(middle.direction, [0.0, 0.0, -1.0]);
        // The top left pixel's centre lies half a focal length left and up.
        let d = camera.ray(0.5, 0.5).direction;
        let n = crate::math::sqrt(1.5);
        for (a, b) in d.iter().zip([-0.5 / n, 0.5 / n, -1.0 / n]) {
            assert!((a - b).abs() < 1e-6, "{d:?}");
        }
        // Two units along that ray, and back to the pixel.
        let p = [0, 1, 2].map(|a| camera.position()[a] + 2.0 * d[a]);
        let [x, y] = camera.project(p).unwrap();
        assert!((x - 0.5).abs() < 1e-5 && (y - 0.5).abs() < 1e-5, "{x} {y}");
        assert_eq!(camera.project([0.0, 0.0, 4.5]), None);
    }

    #[test]
    fn finer_pixels_by_hand() {
        let pose = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]);
        let (focal, center) = ([10.0, 12.0], [3.25, 1.5]);
        let camera = Camera { width: 6, height: 4, focal, center, camera_to_world: pose };
        let fine = camera.finer(3);
        assert_eq!((fine.width, fine.height), (18, 12));
        assert_eq!((fine.focal, fine.center), ([30.0, 36.0], [9.75, 4.5]));
        // The middle one of the nine in pixel (4, 2).
        assert_eq!(fine.ray(13.5, 7.5), camera.ray(4.5, 2.5));
        assert_eq!(camera.finer(1), camera);
        assert_eq!(camera.finer(u32::MAX).width, u32::MAX);
    }
}
