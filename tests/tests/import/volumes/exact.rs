//! Along 1,000 rays, what the programs themselves show.

use pocketnerf_core::{Camera, Ray, SimdLevel, Space};
use pocketnerf_formats::import::Checkpoint;
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::Painter;

use super::{bytes, volume};

/// Most that a value between 0 and 1 may differ from those programs' own, both in f32.
const TOLERANCE: f32 = 1e-5;

#[track_caller]
fn agree(file: &str, program: &str) {
    let contents = bytes(file);
    let checkpoint = Checkpoint::read(&contents).unwrap();
    let name = file.split('.').next().unwrap();
    let rays = bytes(&format!("{name}.rays.bin"));
    let numbers: Vec<f32> = rays.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let expected = numbers.as_chunks::<10>().0;
    assert_eq!(expected.len(), 1000);
    let rays: Vec<Ray> = expected
        .iter()
        .map(|[a, b, c, x, y, z, ..]| Ray { origin: [*a, *b, *c], direction: [*x, *y, *z] })
        .collect();
    for simd in [SimdLevel::Portable, SimdLevel::detect()] {
        let volume = volume(&checkpoint, simd).unwrap();
        assert_eq!(volume.program(), program);
        let found = volume.painter().colors(&rays);
        let (mut apart, mut seen) = (Vec::new(), 0);
        for (found, expected) in found.iter().zip(expected) {
            let each = found.iter().zip(&expected[6..]).map(|(a, b)| (a - b).abs());
            apart.push(each.fold(0.0, f32::max));
            seen += usize::from((0.01..0.99).contains(&expected[9]));
        }
        apart.sort_by(f32::total_cmp);
        println!("{name} {simd}: {:.2e} at most, of 99 % {:.2e}", apart[999], apart[990]);
        assert!(apart[999] < TOLERANCE && seen > 250, "{name} {simd}: {}, {seen}", apart[999]);
    }
}

#[test]
fn tensorf() {
    for file in ["features.th", "plain.th", "harmonics.th", "colors.th", "lines.th"] {
        agree(file, "apchenstu/TensoRF");
    }
}

#[test]
fn svox2() {
    for file in ["nine.npz", "four.npz"] {
        agree(file, "sxyu/svox2");
    }
}

/// A picture is its pixels' rays, in the program's world.
#[test]
fn pictures() {
    let contents = bytes("nine.npz");
    let volume = volume(&Checkpoint::read(&contents).unwrap(), SimdLevel::detect()).unwrap();
    let Space::Box { min, max } = *volume.space() else { panic!("{:?}", volume.space()) };
    let corners = [-0.9, -1.4, -1.1, 1.1, 1.0, 1.7];
    for (found, expected) in [min, max].as_flattened().iter().zip(corners) {
        assert!((found - expected).abs() < 1e-6, "{min:?} {max:?}");
    }
    // A camera of the dataset is nearer in that world.
    let [x, ..] = volume.scene().to_model([3.0, 0.0, 0.0]);
    assert!((x - 2.0).abs() < 1e-6, "{x}");
    let pose = Camera::look_at([3.0, -2.0, 1.0], [0.1, -0.2, 0.3], [0.0, 0.0, 1.0]);
    let camera = Camera::from_fov_x(40, 24, 0.9, pose);
    let mut painter = volume.painter();
    let picture = painter.paint(&camera, &Lens::Pinhole).unwrap().clone();
    let pixel = |i: u16| camera.ray(f32::from(i % 40) + 0.5, f32::from(i / 40) + 0.5);
    let colors = painter.colors(&(0..40 * 24).map(pixel).collect::<Vec<_>>());
    assert_eq!(picture.rgba, colors.as_flattened());
    assert_eq!((picture.width, picture.height), (40, 24));
    assert!(picture.stats.samples > 1000 && picture.rgba.iter().any(|value| *value > 0.2));
}
