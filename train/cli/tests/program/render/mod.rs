//! `pocketnerf render`.

mod geometry;
mod paths;
mod videos;

use std::path::Path;
use std::process::{Command, Output};

use pocketnerf_train::picture::image_file;
use serde_json::Value;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../embed-demo/still-life.pnerf");

fn render(out: &Path, options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pocketnerf"))
        .args(["render", MODEL, "--width", "96", "--height", "64", "--out"])
        .arg(out)
        .args(options)
        .output()
        .unwrap()
}

fn pixels(path: &Path) -> Vec<u8> {
    let picture = image_file::open(path).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (96, 64));
    picture.into_raw()
}

fn difference(a: &[u8], b: &[u8]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn a_deadline_long_enough_gives_the_same_picture_and_a_short_one_a_coarser() {
    let folder = tempfile::tempdir().unwrap();
    let paths =
        ["whole", "long", "short"].map(|name| folder.path().join(name).with_extension("png"));
    for (path, options) in
        paths.iter().zip([&[][..], &["--deadline-ms", "60000"], &["--deadline-ms", "1"]])
    {
        let output = render(path, options);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said = String::from_utf8(output.stdout).unwrap();
        let one_ray = [options, &["--antialias", "off"]].concat();
        let pixels = String::from_utf8(render(path, &one_ray).stdout).unwrap();
        assert_eq!(pixels.contains("every pixel in"), !options.is_empty(), "{pixels}");
        assert!(render(path, options).status.success());
        // Pixels of 96 are four times as large as those of the model's photographs.
        assert_eq!(said.contains("every ray in"), !options.is_empty(), "{said}");
    }
    let [whole, long, short] = paths.map(|path| pixels(&path));
    assert_eq!(whole, long);
    // At least every 16th ray, whatever the machine: nothing at all is off by 94.7 levels. A
    // millisecond may be enough for more.
    let short = difference(&whole, &short);
    assert!(short < 67.0, "{short}");
}

#[test]
fn less_quality_is_less_like_the_finest() {
    let folder = tempfile::tempdir().unwrap();
    let at = |quality: &str| {
        let path = folder.path().join(quality).with_extension("png");
        assert!(render(&path, &["--quality", quality]).status.success());
        pixels(&path)
    };
    let [finest, usual, fastest] = ["1", "0.5", "0"].map(at);
    let (usual, fastest) = (difference(&finest, &usual), difference(&finest, &fastest));
    assert!(usual < fastest && fastest < 20.0, "{usual} {fastest}");
}

/// Small pictures are means of larger ones, and the program says so.
#[test]
fn a_small_picture_has_many_rays_a_pixel() {
    let folder = tempfile::tempdir().unwrap();
    let at = |rays: &str| {
        let path = folder.path().join(rays).with_extension("png");
        let output = render(&path, &["--json", "--quality", "1", "--antialias", rays]);
        let object: Value = serde_json::from_slice(&output.stdout).unwrap();
        let doubts = object["warnings"].as_array().unwrap().len();
        (pixels(&path), object["rays_per_pixel"].as_u64().unwrap(), doubts)
    };
    let [auto, four, off] = ["auto", "4", "off"].map(at);
    assert_eq!((auto.1, auto.2, off.1, off.2), (16, 0, 1, 1));
    assert_eq!(auto, four);

    let large = folder.path().join("large.png");
    let size = ["--width", "384", "--height", "256"];
    let command = [&["render", MODEL, "--quality", "1"][..], &size].concat();
    let mut program = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
    assert!(program.args(command).arg("--out").arg(&large).output().unwrap().status.success());
    let large = image_file::open(&large).unwrap().to_rgb8();
    let mean = |x: u32, y: u32, c: usize| {
        let rays = (0..16).map(|i| large.get_pixel(4 * x + i % 4, 4 * y + i / 4)[c]);
        rays.map(f64::from).sum::<f64>() / 16.0
    };
    for (i, byte) in auto.0.iter().enumerate() {
        let [x, y] = [i / 3 % 96, i / 3 / 96].map(|at| at as u32);
        // Bytes of the larger picture are rounded.
        assert!((f64::from(*byte) - mean(x, y, i % 3)).abs() < 1.01, "{x} {y}");
    }
    assert!(difference(&auto.0, &off.0) > 3.0);
}

#[test]
fn numbers_that_make_no_sense_are_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("never.png");
    for options in [
        ["--quality", "1.5"],
        ["--quality", "nan"],
        ["--deadline-ms", "0"],
        ["--antialias", "0"],
        ["--antialias", "65"],
    ] {
        assert_eq!(render(&out, &options).status.code(), Some(2), "{options:?}");
        assert!(!out.exists());
    }
}
