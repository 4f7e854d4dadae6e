//! What a program is to know of a band of a picture: `Frame` in `ray.wgsl`.

use pocketnerf_core::Camera;
use pocketnerf_core::render::Detail;

/// Rows of a picture, and the rays of their pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Right, up and back of the camera, and its position.
    pose: [[f32; 4]; 4],
    /// Focal lengths, then the principal point, pixels.
    lens: [f32; 4],
    /// Where the camera looks.
    axis: [f32; 4],
    /// Least light that passes, and below how much samples stand for two steps.
    detail: [f32; 4],
    pub(crate) width: u32,
    first_row: u32,
    pub(crate) rows: u32,
    /// Whether rays are given: the camera does not matter then.
    has_rays: bool,
}

impl Frame {
    /// Rows of the picture that `camera` takes of a model whose rays end where less light than
    /// `min_transmittance` passes. `rows`: the picture's width, the first row and how many.
    #[must_use]
    pub fn of_camera(
        camera: &Camera,
        detail: &Detail,
        min_transmittance: f32,
        rows: [u32; 3],
    ) -> Self {
        let m = &camera.camera_to_world;
        let ([fx, fy], [cx, cy]) = (camera.focal, camera.center);
        Self {
            pose: [0, 1, 2, 3].map(|c| [m[c], m[4 + c], m[8 + c], 0.0]),
            lens: [fx, fy, cx, cy],
            has_rays: false,
            ..Self::of_rays(camera.axis(), detail, min_transmittance, rows)
        }
    }

    /// The same of a camera that looks along `axis` and whose rays are given.
    #[must_use]
    pub fn of_rays(
        [x, y, z]: [f32; 3],
        detail: &Detail,
        min_transmittance: f32,
        [width, first_row, rows]: [u32; 3],
    ) -> Self {
        let least = min_transmittance.max(detail.min_transmittance);
        Self {
            axis: [x, y, z, 0.0],
            detail: [least, detail.coarse_step_below, 0.0, 0.0],
            width,
            first_row,
            rows,
            has_rays: true,
            ..Self::default()
        }
    }

    /// The uniform buffer.
    #[must_use]
    pub fn words(&self) -> [u32; 36] {
        let mut words = [0; 36];
        let [a, b, c, d] = self.pose;
        let numbers = [a, b, c, d, self.lens, self.axis, self.detail];
        let rows = [self.width, self.first_row, self.rows, u32::from(self.has_rays)];
        let bits = numbers.as_flattened().iter().map(|number| number.to_bits());
        // 1 four times: see `times` in `ray.wgsl`.
        let all = bits.chain(rows).chain([1; 4]);
        words.iter_mut().zip(all).for_each(|(to, word)| *to = word);
        words
    }
}
