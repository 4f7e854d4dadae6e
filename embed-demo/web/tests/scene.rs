//! The functions behind the page.

use pocketnerf_core::query::Depth;
use pocketnerf_core::render::Tiles;
use pocketnerf_core::space::Contracted;
use pocketnerf_core::{
    Camera, ColorSpace, Display, Model, RenderOptions, SimdLevel, Space, Tuning, render_tile,
};
use pocketnerf_formats::Precision;
use pocketnerf_web::Scene;

const STILL_LIFE: &[u8] = include_bytes!("../../still-life.pnerf");

#[test]
fn tiles_are_those_of_every_host() {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let own = file.about.camera.unwrap();
    let simd = SimdLevel::detect();
    let mut scene = Scene::open(STILL_LIFE, simd).unwrap();
    let camera = scene.own_camera(90, 100);
    assert_eq!(camera, Camera::from_fov_x(90, 100, own.fov_x, own.camera_to_world));
    let options = RenderOptions::new(&file.model, simd, Tuning::FAST);
    let mut scratch = vec![0.0; options.scratch_len()];
    let count = scene.begin(&camera, 0.5).unwrap();
    assert_eq!(count as usize, Tiles::new(90, 100).len());
    for (number, tile) in Tiles::new(90, 100).enumerate() {
        let mut rgba = vec![0.0; 4 * tile.pixels()];
        render_tile(&file.model, &camera, tile, &options, &mut scratch, &mut rgba, None).unwrap();
        let over = |p: &[f32; 4]| {
            let [r, g, b] = file.model.display.rgb8(*p);
            [r, g, b, 255]
        };
        let expected: Vec<u8> = rgba.as_chunks::<4>().0.iter().flat_map(over).collect();
        assert_eq!(scene.tile(number as u32, false).unwrap(), (tile, &expected[..]));
    }
    // With depth, as well.
    let tile = Tiles::new(90, 100).get(1).unwrap();
    let (mut rgba, mut depth) = (vec![0.0; 4 * tile.pixels()], vec![0.0; tile.pixels()]);
    let out = Some(&mut depth[..]);
    let stats =
        render_tile(&file.model, &camera, tile, &options, &mut scratch, &mut rgba, out).unwrap();
    scene.tile(1, true).unwrap();
    assert_eq!(scene.stats(), stats);
    assert!(stats.samples > 0);
    assert_eq!(scene.colors()[..rgba.len()], rgba);
    assert_eq!(scene.depths()[..depth.len()], depth);
    assert!(depth.iter().any(|t| t.is_finite()) && depth.contains(&f32::INFINITY));
}

#[test]
fn what_a_gpu_is_given() {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let mut scene = Scene::open(STILL_LIFE, SimdLevel::detect()).unwrap();
    let parts = scene.parts().unwrap();
    assert!(parts.program().contains("fn render("));
    assert!(4 * parts.packed().tables.len() > STILL_LIFE.len() / 4);
    // The camera: its columns, its lens, and the rows.
    assert_eq!(scene.frame(), None);
    let camera = scene.own_camera(90, 100);
    scene.begin(&camera, 1.0).unwrap();
    let frame = scene.frame().unwrap();
    let model = file.about.scene.camera_to_model(&camera).camera_to_world;
    let expected: Vec<u32> = (0..12).map(|i| model[4 * (i % 3) + i / 3].to_bits()).collect();
    let columns: Vec<u32> = (0..4).flat_map(|c| frame[4 * c..4 * c + 3].to_vec()).collect();
    assert_eq!(columns, expected);
    assert_eq!(frame[16], camera.focal[0].to_bits());
    assert_eq!(frame[28..], [90, 0, 100, 0, 1, 1, 1, 1]);
    // Colours become bytes over the background.
    let pixel = [0.25, 0.5, 0.0, 0.5];
    scene.colors()[4..8].copy_from_slice(&pixel);
    let [r, g, b] = file.model.display.rgb8(pixel);
    assert_eq!(scene.show(2)[4..], [r, g, b, 255]);
    assert_eq!(scene.show(usize::MAX).len(), 4 * Tiles::MOST_PIXELS);
}

#[test]
fn a_packed_file_shows_the_same() {
    let packed = pocketnerf_formats::pack(STILL_LIFE).unwrap();
    let simd = SimdLevel::detect();
    let scenes = [STILL_LIFE, packed.leak()].map(|bytes| Scene::open(bytes, simd).unwrap());
    let [ordinary, packed] = scenes.map(|mut scene| {
        let camera = scene.own_camera(60, 50);
        scene.begin(&camera, 1.0).unwrap();
        scene.tile(0, false).unwrap().1.to_vec()
    });
    assert!(packed == ordinary);
}

#[test]
fn a_linear_model_is_shown_in_srgb() {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let display =
        Display { background: [0.5; 3], color_space: ColorSpace::Linear, ..file.model.display };
    let model = Model { display, ..file.model };
    let bytes = pocketnerf_formats::write(&model, &file.about, Precision::I8).unwrap().leak();
    let mut scene = Scene::open(bytes, SimdLevel::detect()).unwrap();
    let away = Camera::look_at([0.0, 0.0, 9.0], [0.0, 0.0, 99.0], [0.0, 1.0, 0.0]);
    scene.begin(&Camera::from_fov_x(8, 8, 0.7, away), 0.5).unwrap();
    // 0.5 in sRGB is 187.5 of 255.
    assert!(
        scene.tile(0, false).unwrap().1.as_chunks().0.iter().all(|p| *p == [188, 188, 188, 255])
    );
}

/// What the page turns around, and how near it goes: the cube that keeps its shape.
#[test]
fn a_scene_without_an_end_is_looked_at_from_within_its_cube() {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let space = Space::Contracted(Contracted { center: [1.0, -2.0, 0.5], radius: 3.0 });
    let about = pocketnerf_formats::About {
        camera: None,
        scene: pocketnerf_formats::Scene::default(),
        ..file.about
    };
    let model = Model { space, ..file.model };
    let bytes = pocketnerf_formats::write(&model, &about, Precision::I8).unwrap().leak();
    let mut scene = Scene::open(bytes, SimdLevel::detect()).unwrap();
    let facts = scene.facts().0;
    assert_eq!(facts[20..24], [1.0, -2.0, 0.5, 6.0]);
    // No distances, and no nearest object; steps in the cube are three times as long as a unit's.
    assert_eq!((facts[29], facts[51]), (0.0, 0.0));
    assert_eq!(facts[30], 3.0 * file.model.sampling.step);
    assert_eq!(facts[32..38], [-2.0, -5.0, -2.5, 4.0, 1.0, 3.5]);
    // A camera of the cube's size away from its centre sees something, as a GPU would.
    let camera = scene.own_camera(32, 32);
    let eye = camera.position();
    let away: f32 = (0..3).map(|a| (eye[a] - facts[20 + a]).powi(2)).sum::<f32>().sqrt();
    assert!((away - 3.0).abs() < 1e-4, "{away}");
    scene.begin(&camera, 1.0).unwrap();
    let (_, pixels) = scene.tile(0, false).unwrap();
    assert!(pixels.as_chunks::<4>().0.iter().any(|p| *p != pixels[..4]));
    assert!(scene.parts().unwrap().program().contains("RADIUS"));
    let refused = scene.pick(&camera, [16.0; 2]).unwrap_err();
    assert!(refused.contains("not a box"), "{refused}");
}

#[test]
fn a_pick_is_the_median_depth() {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let simd = SimdLevel::detect();
    let mut scene = Scene::open(STILL_LIFE, simd).unwrap();
    let camera = scene.own_camera(40, 40);
    let probe = file.probe(simd, Tuning::SMALL).unwrap();
    let mut scratch = vec![0.0; probe.scratch_len()];
    let (mut hits, step) = (0, file.model.sampling.step);
    for i in 0..1600 {
        let [x, y] = [(i % 40) as f32 + 0.5, (i / 40) as f32 + 0.5];
        let (mut depth, ray) = ([0.0], camera.ray(x, y));
        probe.depths(&[ray], Depth::Median, None, &mut scratch, &mut depth).unwrap();
        let [found, at @ ..] = scene.pick(&camera, [x, y]).unwrap();
        if depth[0].is_infinite() || found.is_infinite() {
            assert_eq!(depth[0].is_infinite(), found.is_infinite(), "{x} {y}: {depth:?} {found}");
            continue;
        }
        assert!((found - depth[0]).abs() < 0.1 * step, "{x} {y}: {found} {depth:?}, step {step}");
        let length: f32 = (0..3).map(|a| (at[a] - ray.origin[a]).powi(2)).sum::<f32>().sqrt();
        assert!((length - found).abs() < 1e-4);
        hits += 1;
    }
    assert!(hits > 200, "{hits}");
}

#[test]
fn what_is_wrong_is_said() {
    let simd = SimdLevel::detect();
    let broken = &STILL_LIFE[..STILL_LIFE.len() / 2];
    let expected = pocketnerf_formats::open_verified(broken).unwrap_err().to_string();
    assert_eq!(Scene::open(broken, simd).unwrap_err(), expected);
    let mut scene = Scene::open(STILL_LIFE, simd).unwrap();
    let good = scene.own_camera(8, 8);
    assert!(scene.tile(0, false).unwrap_err().contains("no picture was started"));
    for (camera, expected) in [
        (Camera { width: 0, ..good }, "width and height"),
        (Camera { focal: [f32::NAN; 2], ..good }, "focal"),
        (Camera { center: [f32::INFINITY; 2], ..good }, "principal point"),
        (Camera { camera_to_world: [0.0; 16], ..good }, "pose"),
    ] {
        assert!(scene.begin(&camera, 0.5).unwrap_err().contains(expected));
        assert!(scene.pick(&camera, [1.0; 2]).unwrap_err().contains(expected));
    }
    assert!(scene.begin(&good, f32::NAN).unwrap_err().contains("quality"));
    let tiles = scene.begin(&good, 0.5).unwrap();
    assert!(scene.tile(tiles, false).unwrap_err().contains("no tile of this number"));
    assert!(scene.pick(&good, [f32::NAN, 0.0]).unwrap_err().contains("pick"));
}
