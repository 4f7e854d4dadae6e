//! What a program is to know of a band of a picture: `Frame` in `ray.wgsl`.

use pocketnerf_core::Camera;
use pocketnerf_core::render::Detail;

/// Rows of a picture, and the rays of their pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Right, up and back of the camera, its position, focal lengths and principal point, where
    /// it looks; least light that passes, and below how much samples stand for two steps.
    numbers: [[f32; 4]; 7],
    /// Width of the picture, first row, number of rows; 1 where rays are given, and the camera
    /// does not matter, and 2 where pixels have the numbers that they have in the picture.
    rows: [u32; 4],
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
        let mut frame = Self::of_rays(camera.axis(), detail, min_transmittance, rows);
        for (i, row) in camera.camera_to_world.chunks_exact(4).take(3).enumerate() {
            (0..4).for_each(|c| frame.numbers[c][i] = row[c]);
        }
        let ([fx, fy], [cx, cy]) = (camera.focal, camera.center);
        frame.numbers[4] = [fx, fy, cx, cy];
        frame.rows[3] = 0;
        frame
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
        let mut numbers = [[0.0; 4]; 7];
        numbers[5] = [x, y, z, 0.0];
        numbers[6] = [least, detail.coarse_step_below, 0.0, 0.0];
        Self { numbers, rows: [width, first_row, rows, 1] }
    }

    /// The same, with the rows at their places in a whole picture.
    #[must_use]
    pub const fn in_place(mut self) -> Self {
        self.rows[3] |= 2;
        self
    }

    /// Pixels in a row, and rows.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.rows[0], self.rows[2]]
    }

    /// The uniform buffer.
    #[must_use]
    pub fn words(&self) -> [u32; 36] {
        // The last four are 1: see `times` in `ray.wgsl`.
        let mut words = [1; 36];
        for (to, number) in words.iter_mut().zip(self.numbers.as_flattened()) {
            *to = number.to_bits();
        }
        words[28..32].copy_from_slice(&self.rows);
        words
    }
}
