//! Every camera model, by a ray.

use pocketnerf_core::Camera;

use super::all;
use super::fixture::Capture;
use crate::fixture::{near, unit};

/// The direction (0.3, -0.2, 1), right, down and forward, is shown at these pixels, in pictures
/// of 8x4 pixels with focal lengths of 8 (along y 9 where there are two) and the principal point
/// in the middle. Expected values are from the formulas of COLMAP's documented models in
/// Python's floats, with r2 = 0.13 (the square of the angle in fisheye models). By hand:
/// SIMPLE_PINHOLE 4 + 8 * 0.3, 2 - 8 * 0.2; SIMPLE_RADIAL 4 + 8 * 0.3 * (1 + 0.1 * 0.13).
#[test]
fn a_ray_of_each_camera_model() {
    let (one, two) = ([8.0, 4.0, 2.0], [8.0, 9.0, 4.0, 2.0]);
    let with = |first: &[f64], more: &[f64]| [first, more].concat();
    for (model, numbers, pixel) in [
        ("SIMPLE_PINHOLE", with(&one, &[]), [6.4, 0.4]),
        ("PINHOLE", with(&two, &[]), [6.4, 0.2]),
        ("SIMPLE_RADIAL", with(&one, &[0.1]), [6.4312, 0.3792]),
        ("RADIAL", with(&one, &[0.1, -0.05]), [6.429_172, 0.380_552]),
        ("OPENCV", with(&two, &[0.1, -0.05, 0.01, -0.02]), [6.369_972, 0.218_621]),
        (
            "OPENCV_FISHEYE",
            with(&two, &[0.1, -0.05, 0.02, -0.01]),
            [6.329_433_648_341_444, 0.252_924_763_743_916_9],
        ),
        (
            "FULL_OPENCV",
            with(&two, &[0.1, -0.05, 0.01, -0.02, 0.02, 0.3, 0.04, -0.03]),
            [6.277_519_775_391_945, 0.287_960_168_456_040_9],
        ),
        ("FOV", with(&two, &[0.9]), [6.479_078_034_464_608, 0.140_691_474_151_543_26]),
        (
            "SIMPLE_RADIAL_FISHEYE",
            with(&one, &[0.1]),
            [6.331_010_800_691_251, 0.445_992_799_539_166_15],
        ),
        (
            "RADIAL_FISHEYE",
            with(&one, &[0.1, -0.05]),
            [6.329_359_277_871_285, 0.447_093_814_752_476_56],
        ),
        (
            "THIN_PRISM_FISHEYE",
            with(&two, &[0.1, -0.05, 0.01, -0.02, 0.02, -0.01, 0.03, -0.04]),
            [6.303_641_668_383_136, 0.247_121_568_253_298_12],
        ),
    ] {
        let mut capture = Capture::around();
        capture.cameras = vec![Capture::camera(model, &numbers)];
        let dataset = all(&capture.folder(), 1);
        let view = &dataset.views[0];
        assert_eq!(view.camera.center, [4.0, 2.0], "{model}");
        // Right, up and back are the axes.
        let axes = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
        let camera = Camera { camera_to_world: axes, ..view.camera };
        let [x, y] = pixel.map(|v| v as f32);
        let ray = view.lens.ray(&camera, x, y);
        assert!(near(ray.direction, unit([0.3, 0.2, -1.0])), "{model}: {ray:?}");
        // And shown again where it came from, as are the picture's corners.
        for [x, y] in [[x, y], [0.0, 0.0], [8.0, 4.0], [0.0, 4.0]] {
            let direction = view.lens.ray(&camera, x, y).direction.map(|v| 5.0 * v);
            let [u, v] = view.lens.project(&camera, direction).unwrap();
            assert!((u - x).abs() < 1e-5 && (v - y).abs() < 1e-5, "{model}: {x} {y}: {u} {v}");
        }
    }
}
