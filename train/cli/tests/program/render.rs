//! `pocketnerf render`.

use std::path::Path;
use std::process::{Command, Output};

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
    let picture = image::open(path).unwrap().to_rgb8();
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
        assert_eq!(said.contains("every pixel in"), !options.is_empty(), "{said}");
    }
    let [whole, long, short] = paths.map(|path| pixels(&path));
    assert_eq!(whole, long);
    // At least every 16th pixel, whatever the machine: off by 66.7 levels, nothing at
    // all by 94.7. A millisecond may be enough for more.
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

#[test]
fn numbers_that_make_no_sense_are_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("never.png");
    for options in [["--quality", "1.5"], ["--quality", "nan"], ["--deadline-ms", "0"]] {
        assert_eq!(render(&out, &options).status.code(), Some(2), "{options:?}");
        assert!(!out.exists());
    }
}
