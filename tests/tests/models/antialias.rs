//! Several rays a pixel are what a finer picture shows there, averaged.

use std::time::{Duration, Instant};

use pocketnerf_core::Camera;
use pocketnerf_tests::tiny::Tiny;
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::{Antialias, Picture, Progressive, Renderer, Settings};

const SIZE: [u32; 2] = [67, 41];

fn camera() -> Camera {
    let pose = Camera::look_at([1.6, 1.2, 1.4], [0.3; 3], [0.0, 0.0, 1.0]);
    Camera { center: [30.0, 21.5], ..Camera::from_fov_x(SIZE[0], SIZE[1], 0.9, pose) }
}

fn settings(antialias: Antialias) -> Settings {
    Settings { quality: 1.0, depth: true, antialias, ..Settings::default() }
}

/// The pixel in column x and row y of a picture of n × n times as many: colour, and depth
/// weighted by opacity.
fn by_hand(fine: &Picture, n: usize, [x, y]: [usize; 2]) -> ([f64; 4], f64) {
    let rays = (0..n).flat_map(|j| (0..n).map(move |i| [n * x + i, n * y + j]));
    let (mut color, mut distance, mut opacity) = ([0.0; 4], 0.0, 0.0);
    for at in rays.map(|[x, y]| y * fine.width as usize + x) {
        let ray = [0, 1, 2, 3].map(|c| f64::from(fine.rgba[4 * at + c]));
        color = [0, 1, 2, 3].map(|c| color[c] + ray[c] / (n * n) as f64);
        if fine.depth[at].is_finite() {
            distance += ray[3] * f64::from(fine.depth[at]);
            opacity += ray[3];
        }
    }
    (color, if opacity > 0.0 { distance / opacity } else { f64::INFINITY })
}

#[test]
fn a_pixel_is_the_mean_of_its_rays() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let camera = camera();
    for lens in [Lens::Pinhole, Lens::open_cv([-0.3, 0.1, 0.0, 0.0], [0.01, 0.02])] {
        for n in [2, 3, 8] {
            let render = |camera: &Camera, antialias| {
                let mut renderer = Renderer::new(&model, &settings(antialias));
                renderer.render_through(camera, &lens).unwrap().clone()
            };
            let ours = render(&camera, Antialias::Rays(n));
            let scale = n as f32;
            let fine = Camera {
                width: n * camera.width,
                height: n * camera.height,
                focal: camera.focal.map(|f| scale * f),
                center: camera.center.map(|c| scale * c),
                ..camera
            };
            let fine = render(&fine, Antialias::Off);
            assert_eq!([ours.width, ours.height], SIZE);
            assert_eq!((ours.rgba.len(), ours.depth.len()), (4 * 67 * 41, 67 * 41));
            let mut edges = 0;
            for (i, (pixel, depth)) in
                ours.rgba.as_chunks::<4>().0.iter().zip(&ours.depth).enumerate()
            {
                let (color, distance) = by_hand(&fine, n as usize, [i % 67, i / 67]);
                for (a, b) in pixel.iter().zip(color) {
                    assert!((f64::from(*a) - b).abs() < 1e-5, "{lens:?} {n} {i}: {a} {b}");
                }
                let near = (f64::from(*depth) - distance).abs() < 1e-4;
                assert!(
                    near || f64::from(*depth) == distance,
                    "{lens:?} {n} {i}: {depth} {distance}"
                );
                edges += usize::from((0.05..0.95).contains(&pixel[3]));
            }
            assert!(edges > 30, "{edges}");
            // What it took is what the finer picture takes.
            assert_eq!(ours.stats.samples, fine.stats.samples, "{lens:?} {n}");
        }
    }
}

#[test]
fn one_ray_is_the_usual_picture() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let camera = camera();
    let render = |antialias| {
        let settings = Settings { quality: 0.5, ..settings(antialias) };
        Renderer::new(&model, &settings).render(&camera).unwrap().clone()
    };
    let usual = render(Antialias::Off);
    for antialias in [Antialias::Rays(1), Antialias::Like(camera.focal[0])] {
        let ours = render(antialias);
        assert!(ours.rgba == usual.rgba && ours.depth == usual.depth);
        assert_eq!(ours.stats, usual.stats);
    }
}

/// A finished refinement has the bytes of the picture, whatever the quality.
#[test]
fn refinements_end_with_the_same_picture() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    for (quality, n) in [(1.0, 3), (0.5, 2), (0.2, 4)] {
        let settings = Settings { quality, ..settings(Antialias::Rays(n)) };
        let whole = Renderer::new(&model, &settings).render(&camera()).unwrap().clone();
        let mut progressive = Progressive::new(&model, &camera(), &settings);
        let finished = progressive.refine(Instant::now() + Duration::from_secs(600)).unwrap();
        let refined = progressive.picture();
        assert!(finished && refined.rgba == whole.rgba && refined.depth == whole.depth, "{n}");
        assert_eq!([refined.width, refined.height], SIZE);
    }
}
