//! Every few pixels of a picture.

use pocketnerf_core::Camera;

/// Every few pixels of a camera's picture along both sides, the middle ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EveryFew {
    /// The camera whose pixels these are.
    pub(crate) camera: Camera,
    apart: u32,
}

impl EveryFew {
    /// One pixel in so many along each side.
    pub(crate) fn new(whole: &Camera, apart: u32) -> Self {
        let side = |pixels: u32| (pixels + apart - 1 - apart / 2) / apart;
        let scale = apart as f32;
        // Pixel i is pixel `apart i + apart / 2`, and both have their middle half a pixel further.
        let center = |c: f32| (c - (apart / 2) as f32 - 0.5) / scale + 0.5;
        let camera = Camera {
            width: side(whole.width),
            height: side(whole.height),
            focal: whole.focal.map(|f| f / scale),
            center: whole.center.map(center),
            ..*whole
        };
        Self { camera, apart }
    }

    /// How far apart the pixels of pictures are of which about so many are wanted.
    pub(crate) fn apart<'c>(cameras: impl Iterator<Item = &'c Camera>, wanted: f64) -> u32 {
        let pixels = cameras.map(|camera| f64::from(camera.width) * f64::from(camera.height));
        (pixels.sum::<f64>() / wanted).sqrt().ceil().max(1.0) as u32
    }

    /// Where the pixels are in the whole picture, row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + Clone + use<> {
        let Self { camera: Camera { width, height, .. }, apart } = *self;
        let all = (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]));
        all.map(move |pixel| pixel.map(|i| i * apart + apart / 2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_few_pixels_are_pixels_of_the_view() {
        let pose = Camera::look_at([2.0, 1.0, 1.5], [0.1, 0.0, 0.0], [0.0, 0.0, 1.0]);
        for (apart, size) in [(1, [61, 47]), (3, [20, 16]), (4, [15, 12])] {
            let camera = Camera::from_fov_x(61, 47, 0.9, pose);
            let pixels = EveryFew::new(&camera, apart);
            let few = pixels.camera;
            assert_eq!([few.width, few.height], size);
            for (x, y) in [(0, 0), (size[0] - 1, size[1] - 1), (7, 3)] {
                let whole = [x, y].map(|i| i * apart + apart / 2);
                assert_eq!(pixels.pixels().nth((y * few.width + x) as usize), Some(whole));
                let [at_x, at_y] = whole.map(|i| i as f32 + 0.5);
                assert!(at_x < 61.0 && at_y < 47.0);
                let [found, expected] = [
                    few.ray(x as f32 + 0.5, y as f32 + 0.5).direction,
                    camera.ray(at_x, at_y).direction,
                ];
                (0..3).for_each(|a| assert!((found[a] - expected[a]).abs() < 1e-6));
            }
        }
    }
}
