//! Depth and normals as files, of a ball that is where it is known to be.

use std::path::Path;

use glam::Vec3;
use pocketnerf_core::encoding::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
use pocketnerf_core::field::{Decoder, HashGridField, Shading};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::space::Contracted;
use pocketnerf_core::{
    AnyField, Camera, ColorSpace, DType, Display, Layout, Model, Sampling, Space, TensorView,
};
use pocketnerf_formats::{About, Precision, Scene};
use pocketnerf_train::picture::image_file;

use super::MODEL;
use crate::place::{Place, text};

/// Corners of the grid along an axis; one more lies beyond each side.
const CORNERS: usize = 33;
/// The ball's radius in the model's units, and how much log density grows a unit towards its centre.
const RADIUS: f32 = 0.6;
const STEEP: f32 = 100.0;
/// Half of the light that goes straight towards its centre is held back before this distance from it:
/// the integral of `exp(STEEP (RADIUS - r) + LOG)` over r is ln 2 there.
const LOG: f32 = 4.239;

/// The dataset is turned, twice as large, and its ball is at (1, -2, 3).
const SCENE: Scene<'_> = Scene {
    scale: 2.0,
    rotation: [[0.6, 0.0, 0.8], [0.64, 0.6, -0.48], [-0.48, 0.8, 0.36]],
    translation: [1.0, -2.0, 3.0],
    name: None,
};

/// A file with a ball in a space that is the cube [-`reach`, `reach`]³ in local coordinates, those of the
/// model around the ball.
fn ball(space: Space, reach: f32) -> Vec<u8> {
    let config = HashGridConfig {
        n_levels: 1,
        n_features_per_level: 1,
        log2_hashmap_size: 16,
        base_resolution: CORNERS as u32,
        per_level_scale: 1.0,
        index: GridIndex::Blocked,
    };
    let blocks = CORNERS / 2 + 1;
    let log_density = |entry: usize| {
        let (block, low) = (entry / 8, entry % 8);
        let corner = [
            2 * (block % blocks) + low % 2,
            2 * (block / blocks % blocks) + low / 2 % 2,
            2 * (block / (blocks * blocks)) + low / 4,
        ];
        let p = Vec3::from(
            corner.map(|c| reach * ((c as f32 - 0.5) * 2.0 / (CORNERS - 1) as f32 - 1.0)),
        );
        (STEEP * (RADIUS - p.length()) + LOG).clamp(-60.0, 10.0)
    };
    let bytes = |values: Vec<f32>| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let n = 8 * blocks.pow(3);
    let grid = bytes((0..n).map(log_density).collect());
    let [density, bias, color] = [vec![1.0, 0.0], vec![0.0, 0.0], vec![0.0; 6]].map(bytes);
    let tensor =
        |bytes, shape| TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor).unwrap();
    let mut levels = [TensorView::EMPTY; MAX_LEVELS];
    levels[0] = tensor(&grid, [n as u32, 1]);
    let first = Dense { weight: tensor(&density, [1, 2]), bias: Some(tensor(&bias, [1, 2])) };
    let second = Dense { weight: tensor(&color, [2, 3]), bias: None };
    let decoder = Decoder {
        density: Mlp::new(&[first]).unwrap(),
        color: Mlp::new(&[second]).unwrap(),
        n_features: 1,
        sh_degree: 1,
        shading: Shading::PerRay,
        log_density_bias: 0.0,
    };
    let model = Model {
        field: AnyField::HashGrid(HashGridField { grid: HashGrid { config, levels }, decoder }),
        space,
        occupancy: None,
        sampling: Sampling { step: 0.004, near: 0.0, far: 6.0, min_transmittance: 1e-3 },
        hierarchical: None,
        display: Display {
            background: [1.0; 3],
            color_space: ColorSpace::Srgb,
            tolerance: Display::TOLERANCE,
        },
    };
    let about = About { scene: SCENE, ..About::default() };
    pocketnerf_formats::write(&model, &about, Precision::F32).unwrap()
}

/// The values of a file's channels, which have these names.
fn channels<const N: usize>(path: &Path, names: [&str; N]) -> [Vec<f32>; N] {
    let image = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
    let list = image.layer_data.channel_data.list;
    assert!(list.iter().map(|channel| channel.name.to_string()).eq(names));
    let values = list.iter().map(|channel| channel.sample_data.values_as_f32().collect());
    values.collect::<Vec<_>>().try_into().unwrap()
}

#[test]
fn numbers_are_in_the_units_and_axes_of_the_dataset() {
    let place = Place::new();
    let around = Contracted { center: [0.0; 3], radius: 1.0 };
    for (space, reach) in
        [(Space::Box { min: [-1.0; 3], max: [1.0; 3] }, 1.0), (Space::Contracted(around), 2.0)]
    {
        std::fs::write(place.path("ball.pnerf"), ball(space, reach)).unwrap();
        sees_the_ball(&place);
    }
}

/// A camera in the dataset's coordinates sees the ball where it is there, and facing away from its
/// centre.
fn sees_the_ball(place: &Place) {
    let center = Vec3::from(SCENE.translation);
    let eye = center + Vec3::new(3.0, -4.0, 2.0);
    let pose = Camera::look_at(eye.to_array(), center.to_array(), [0.0, 0.0, 1.0]);
    let camera = Camera::from_fov_x(40, 30, 50f32.to_radians(), pose);
    let size = "--width 40 --height 30 --fov 50";
    for options in ["--out a.png --depth=exr --normals=exr", "--out b.png --depth --normals"] {
        let mut command = place.command(&format!("render ball.pnerf {size} {options}"));
        let output = command.args(["--pose", &format!("{pose:?}")]).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    let [depth] = channels(&place.path("a.depth.exr"), ["Y"]);
    let [z, y, x] = channels(&place.path("a.normals.exr"), ["B", "G", "R"]);
    let open = |name: &str| image_file::open(place.path(name)).unwrap();
    let (steps, colors) = (open("b.depth.png"), open("b.normals.png"));
    let steps = steps.as_luma16().unwrap().as_raw();
    let colors = colors.as_rgb8().unwrap().as_raw().as_chunks::<3>().0;

    let radius = SCENE.scale * RADIUS;
    let (mut seen, mut empty) = (0, 0);
    for i in 0..40 * 30 {
        let ray = camera.ray((i % 40) as f32 + 0.5, (i / 40) as f32 + 0.5);
        let way = Vec3::from(ray.direction);
        let middle = (center - eye).dot(way);
        let beside = (eye + middle * way - center).length();
        let normal = Vec3::new(x[i], y[i], z[i]);
        if beside < 0.7 * radius {
            let t = middle - (radius * radius - beside * beside).sqrt();
            // Where light comes in at a slant, it is held back a hundredth of a unit before.
            assert!((depth[i] - t).abs() < 0.05, "{i}: {} for {t}", depth[i]);
            assert!((f32::from(steps[i]) - 1000.0 * depth[i]).abs() < 0.6, "{i}: {}", steps[i]);
            let expected = (eye + t * way - center) / radius;
            let angle = normal.dot(expected).clamp(-1.0, 1.0).acos().to_degrees();
            assert!((normal.length() - 1.0).abs() < 1e-5 && angle < 5.0, "{i}: {angle} degrees");
            let bytes = normal.to_array().map(|v| 127.5 * (v + 1.0));
            assert!(colors[i].iter().zip(bytes).all(|(c, v)| (f32::from(*c) - v).abs() < 0.6));
            seen += 1;
        } else if beside > 1.5 * radius {
            assert_eq!((depth[i], steps[i]), (f32::INFINITY, 0), "{i}");
            assert_eq!((normal, colors[i]), (Vec3::ZERO, [0; 3]), "{i}");
            empty += 1;
        }
    }
    assert!(seen > 100 && empty > 300, "{seen} {empty}");
}

/// Files lie beside the pictures of a folder, too, and are the same at any number of threads.
#[test]
fn each_picture_of_a_folder_has_its_files() {
    let place = Place::new();
    let render = format!("render {MODEL} --width 48 --height 32 --orbit 2 --depth=exr --normals");
    let written = |options: &str| {
        place.ok(&format!("{render} --out frames {options}"));
        let entries = std::fs::read_dir(place.path("frames")).unwrap();
        let mut names: Vec<_> =
            entries.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names.into_iter().map(|name| (place.bytes(&format!("frames/{name}")), name)).collect()
    };
    let one: Vec<(Vec<u8>, String)> = written("--threads 1");
    let names = ["depth.exr", "normals.png", "png"];
    let expected = ["000", "001"].iter().flat_map(|i| names.map(|name| format!("{i}.{name}")));
    assert!(one.iter().map(|(_, name)| name.clone()).eq(expected));
    assert!(one == written("--threads 3"));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let place = Place::new();
    let line = place.line(&format!("render {MODEL} --video v.mp4 --normals=exr"));
    assert_eq!(line, "--normals: a video has none; give a folder with --out too");
    for options in ["--depth=tiff", "--normals=jpg", "--normals --deadline-ms 9"] {
        let output = place.run(&format!("render {MODEL} --out a.png {options}"));
        assert_eq!(output.status.code(), Some(2), "{options}");
    }
    assert!(!place.path("a.png").exists());
}
