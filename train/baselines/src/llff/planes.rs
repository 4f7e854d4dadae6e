//! Where rays meet the planes of an image.

use glam::{Mat3, Vec3};
use pocketnerf_core::{Camera, Ray};

/// Parallel planes before a camera, near ones first: their distances along its axis are evenly
/// spaced in disparity. Each shows what the camera's pixels see there.
#[derive(Clone, Debug)]
pub(super) struct Planes {
    camera: Camera,
    from_world: Mat3,
    position: Vec3,
    pub(super) depths: Vec<f32>,
}

/// The four pixels of a plane around a point: the first one, and where the point lies among them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub(super) first: usize,
    pub(super) fraction: [f32; 2],
}

/// A ray in a camera's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    origin: Vec3,
    direction: Vec3,
}

impl Planes {
    pub(super) fn new(camera: Camera, n: usize, [near, far]: [f32; 2]) -> Self {
        let m = &camera.camera_to_world;
        let row = |r: usize| Vec3::new(m[4 * r], m[4 * r + 1], m[4 * r + 2]);
        // The rows of a rotation are the columns of its inverse.
        let from_world = Mat3::from_cols(row(0), row(1), row(2));
        let share = |k: usize| k as f32 / (n - 1).max(1) as f32;
        let depth = |k: usize| 1.0 / (1.0 / near + share(k) * (1.0 / far - 1.0 / near));
        let position = Vec3::from(camera.position());
        Self { camera, from_world, position, depths: (0..n).map(depth).collect() }
    }

    pub(super) fn size(&self) -> [usize; 2] {
        [self.camera.width as usize, self.camera.height as usize]
    }

    /// Focal length in x, pixels.
    pub(super) fn focal(&self) -> f32 {
        self.camera.focal[0]
    }

    pub(super) fn pixels(&self) -> usize {
        self.size().iter().product()
    }

    /// The ray in the camera's coordinates; `None` where it does not look the same way.
    pub(super) fn local(&self, ray: &Ray) -> Option<Local> {
        let origin = self.from_world * (Vec3::from(ray.origin) - self.position);
        let direction = self.from_world * Vec3::from(ray.direction);
        (direction.z < -1e-3).then_some(Local { origin, direction })
    }

    /// Where a ray meets a plane; `None` beyond its edges.
    #[inline]
    pub(super) fn spot(&self, local: &Local, plane: usize) -> Option<Spot> {
        let Local { origin, direction } = local;
        let depth = self.depths[plane];
        let t = (-depth - origin.z) / direction.z;
        if t <= 0.0 {
            return None;
        }
        let at = [origin.x + t * direction.x, origin.y + t * direction.y];
        let Camera { focal, center, width, height, .. } = self.camera;
        let u = center[0] + focal[0] * at[0] / depth - 0.5;
        let v = center[1] - focal[1] * at[1] / depth - 0.5;
        spot([u, v], [width as usize, height as usize])
    }

    /// The point of a plane behind a pixel, scene units.
    pub(super) fn point(&self, plane: usize, x: usize, y: usize) -> [f32; 3] {
        let Camera { focal, center, .. } = self.camera;
        let depth = self.depths[plane];
        let local = Vec3::new(
            (x as f32 + 0.5 - center[0]) / focal[0] * depth,
            -(y as f32 + 0.5 - center[1]) / focal[1] * depth,
            -depth,
        );
        (self.position + self.from_world.transpose() * local).to_array()
    }
}

/// The pixels around a point, which is in pixels from the middle of the first one.
pub(super) fn spot([u, v]: [f32; 2], [width, height]: [usize; 2]) -> Option<Spot> {
    let (right, bottom) = ((width - 1) as f32, (height - 1) as f32);
    // NaN is nowhere.
    if !(u >= 0.0 && v >= 0.0 && u <= right && v <= bottom) || width < 2 || height < 2 {
        return None;
    }
    let x = (u as usize).min(width - 2);
    let y = (v as usize).min(height - 2);
    Some(Spot { first: y * width + x, fraction: [u - x as f32, v - y as f32] })
}

impl Spot {
    /// The pixels and their weights, in rows of `width`.
    pub(super) fn pixels(&self, width: usize) -> [(usize, f32); 4] {
        let [u, v] = self.fraction;
        [
            (self.first, (1.0 - u) * (1.0 - v)),
            (self.first + 1, u * (1.0 - v)),
            (self.first + width, (1.0 - u) * v),
            (self.first + width + 1, u * v),
        ]
    }
}
