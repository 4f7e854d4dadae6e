//! Every few pixels of a picture.

use pocketnerf_core::Camera;

/// The camera whose pixels are every few of another's, the middle ones.
pub(crate) fn every_few(camera: &Camera, apart: u32) -> Camera {
    let side = |pixels: u32| (pixels + apart - 1 - apart / 2) / apart;
    let scale = apart as f32;
    // Pixel i is pixel `apart i + apart / 2`, and both have their middle half a pixel further.
    let center = |c: f32| (c - (apart / 2) as f32 - 0.5) / scale + 0.5;
    Camera {
        width: side(camera.width),
        height: side(camera.height),
        focal: camera.focal.map(|f| f / scale),
        center: camera.center.map(center),
        ..*camera
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
            let few = every_few(&camera, apart);
            assert_eq!([few.width, few.height], size);
            for (x, y) in [(0, 0), (size[0] - 1, size[1] - 1), (7, 3)] {
                let at = |i: u32| (i * apart + apart / 2) as f32 + 0.5;
                assert!(at(x) < 61.0 && at(y) < 47.0);
                let [found, expected] = [
                    few.ray(x as f32 + 0.5, y as f32 + 0.5).direction,
                    camera.ray(at(x), at(y)).direction,
                ];
                (0..3).for_each(|a| assert!((found[a] - expected[a]).abs() < 1e-6));
            }
        }
    }
}
