//! Pictures through a lens.

use pocketnerf_core::Camera;
use pocketnerf_core::reference;
use pocketnerf_tests::tiny::Tiny;
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::{Renderer, Settings};

/// A pixel of a picture through a lens is what a pinhole camera shows in the direction
/// of the lens's ray.
#[test]
fn pixels_are_those_of_their_rays() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let pose = Camera::look_at([1.6, 1.2, 1.4], [0.3; 3], [0.0, 0.0, 1.0]);
    let camera = Camera::from_fov_x(37, 21, 0.9, pose);
    let settings = Settings { quality: 1.0, depth: true, ..Settings::default() };
    let mut renderer = Renderer::new(&model, &settings);
    for lens in [
        Lens::open_cv([-0.3, 0.1, 0.0, 0.0], [0.01, 0.02]),
        Lens::fisheye([0.1, 0.0, 0.0, 0.0]),
        Lens::open_cv([-0.3, 0.1, 0.0, 0.0], [0.0; 2]).skewed(0.1),
        Lens::Equirectangular,
    ] {
        let picture = renderer.render_through(&camera, &lens).unwrap().clone();
        let mut seen = 0;
        for (i, pixel) in picture.rgba.chunks_exact(4).enumerate() {
            let ray = lens.ray(&camera, (i % 37) as f32 + 0.5, (i / 37) as f32 + 0.5);
            let expected = reference::render_ray(&model, &ray).unwrap();
            let [r, g, b] = expected.rgb;
            for (a, b) in pixel.iter().zip([r, g, b, expected.opacity]) {
                assert!((a - b).abs() < 1e-4, "{lens:?} {i}: {pixel:?} {expected:?}");
            }
            seen += u32::from(pixel[3] > 0.01);
        }
        assert!(seen > 30, "{seen}");
        assert_eq!(picture.depth.len(), 37 * 21);
    }
}
