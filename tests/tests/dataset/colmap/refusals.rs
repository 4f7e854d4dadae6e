//! Models that are wrong, and the line that says so.

use std::path::Path;

use pocketnerf_train::dataset::{Split, load};

use super::fixture::{Camera, Capture};
use crate::refusals::refusal;

/// The refusal of a capture, after the name of the file.
fn wrong(capture: &Capture, file: &str) -> String {
    let folder = capture.folder();
    let message = refusal(folder.path());
    let start = format!("D/sparse/0/{file}: ");
    message.strip_prefix(&start).unwrap_or_else(|| panic!("{message}")).to_owned()
}

#[test]
fn numbers_that_make_no_sense() {
    let again = "; write the model again with COLMAP";
    let with = |model: &'static str, numbers: &[f64]| {
        let cameras = vec![Capture::camera(model, numbers)];
        wrong(&Capture { cameras, ..Capture::around() }, "cameras.bin")
    };
    for (model, numbers, expected) in [
        ("SIMPLE_PINHOLE", &[0.0, 4.0, 2.0][..], "its focal length is 0, expected pixels above 0"),
        (
            "SIMPLE_PINHOLE",
            &[f64::NAN, 4.0, 2.0],
            "its focal length is NaN, expected pixels above 0",
        ),
        (
            "SIMPLE_PINHOLE",
            &[8.0, 1e9, 2.0],
            "its principal point is at 1000000000, expected pixels",
        ),
        ("FOV", &[8.0, 8.0, 4.0, 2.0, 3.2], "omega is 3.2, expected radians below pi"),
        (
            "RADIAL",
            &[8.0, 4.0, 2.0, 0.1, 1e9],
            "a lens coefficient is 1000000000, expected a small one",
        ),
    ] {
        assert_eq!(with(model, numbers), format!("camera 1: {expected}{again}"));
    }
    let mut capture = Capture::around();
    capture.cameras[0].size = [8, 0];
    let found = wrong(&capture, "cameras.bin");
    assert_eq!(found, format!("camera 1: 8x0 pixels, expected 1x1 to below a million{again}"));

    let images = |change: fn(&mut Capture)| {
        let mut capture = Capture::around();
        change(&mut capture);
        wrong(&capture, "images.bin")
    };
    for (change, expected) in [
        (
            (|c| c.images[1].rotation = [0.0; 4]) as fn(&mut Capture),
            "the image b.png: a rotation of length 0, expected 1",
        ),
        (
            |c| c.images[1].translation[2] = f64::INFINITY,
            "the image b.png: the pose holds a number that is not finite, expected finite numbers",
        ),
        (
            |c| c.images[1].name = "a.png".to_owned(),
            "the image a.png is there twice, expected once",
        ),
        (
            |c| c.images[1].camera = 4,
            "the image b.png has camera 4, which cameras.bin does not list",
        ),
        (|c| c.images.clear(), "no image is registered, expected at least one"),
    ] {
        assert_eq!(images(change), format!("{expected}{again}"));
    }
}

#[test]
fn camera_models_that_cannot_be_read() {
    let capture = Capture::around();
    let folder = capture.folder();
    let [mut cameras, ..] = capture.binary();
    cameras[12] = 11;
    folder.write("sparse/0/cameras.bin", cameras);
    let hint = "cannot be read; undistort the images with COLMAP's image_undistorter first";
    assert_eq!(
        refusal(folder.path()),
        format!("D/sparse/0/cameras.bin: camera 1, of the model with the number 11, {hint}")
    );
    let folder = capture.folder();
    ["cameras", "images", "points3D"]
        .iter()
        .for_each(|name| folder.remove(&format!("sparse/0/{name}.bin")));
    capture.write_text(&folder, "sparse/0");
    folder.write("sparse/0/cameras.txt", "1 RAD_TAN_THIN_PRISM_FISHEYE 8 4 8 8 4 2");
    assert_eq!(
        refusal(folder.path()),
        format!(
            "D/sparse/0/cameras.txt: camera 1, of the model RAD_TAN_THIN_PRISM_FISHEYE, {hint}"
        )
    );
}

#[test]
fn texts_that_are_wrong() {
    let capture = Capture::around();
    for (file, text, expected) in [
        ("cameras.txt", "# x\n\n1 PINHOLE 8", "line 3: the line ends, expected a height"),
        ("cameras.txt", "1 PINHOLE 8 4 1 2", "line 1: camera 1: 2 numbers for PINHOLE, expected 4"),
        ("cameras.txt", "one", "line 1: \"one\", expected a camera's number"),
        ("images.txt", "1 1 0 0", "line 1: the line ends, expected four numbers of a rotation"),
        ("images.txt", "1 1 0 0 0 0 0 0 1", "an image has no name, expected that of its file"),
        ("points3D.txt", "1 0 0 0 9 9 9 0.5 1", "line 1: the line ends, expected the number of a"),
    ] {
        let folder = capture.folder();
        ["cameras", "images", "points3D"]
            .iter()
            .for_each(|name| folder.remove(&format!("sparse/0/{name}.bin")));
        capture.write_text(&folder, "sparse/0");
        folder.write(&format!("sparse/0/{file}"), text);
        let message = refusal(folder.path());
        assert!(message.starts_with(&format!("D/sparse/0/{file}: {expected}")), "{message}");
    }
}

#[test]
fn files_that_lie_and_files_that_are_missing() {
    let capture = Capture::around();
    let [cameras, images, points] = capture.binary();
    let huge = [&u64::MAX.to_le_bytes()[..], &images[8..]].concat();
    let more = [&4u64.to_le_bytes()[..], &images[8..]].concat();
    let fewer = [&2u64.to_le_bytes()[..], &images[8..]].concat();
    let again = "; write the model again with COLMAP";
    for (file, bytes, expected) in [
        (
            "images.bin",
            &huge[..],
            format!(
                "18446744073709551615 images are announced, but {} bytes follow, expected at least \
                 73 for each",
                images.len() - 8
            ),
        ),
        // 8 and three times 64 + 8 + 48 bytes, and names of 6, 6 and 12, are there.
        (
            "images.bin",
            &more,
            "cut off: 0 bytes are left at byte 392, expected 4 or more".to_owned(),
        ),
        ("images.bin", &fewer, "132 bytes follow the last of its images, expected none".to_owned()),
        ("cameras.bin", &cameras[..50], {
            "1 cameras are announced, but 42 bytes follow, expected at least 48 for each".to_owned()
        }),
        ("points3D.bin", &points[..points.len() - 3], {
            "3 images of a point are announced, but 21 bytes follow, expected at least 8 for each"
                .to_owned()
        }),
        (
            "cameras.bin",
            &[][..],
            "cut off: 0 bytes are left at byte 0, expected 8 or more".to_owned(),
        ),
    ] {
        let folder = capture.folder();
        folder.write(&format!("sparse/0/{file}"), bytes);
        assert_eq!(refusal(folder.path()), format!("D/sparse/0/{file}: {expected}{again}"));
    }
    let folder = capture.folder();
    folder.remove("sparse/0/cameras.bin");
    assert!(refusal(folder.path()).starts_with("D/sparse/0/cameras.bin: cannot be read: No such"));
    std::fs::remove_dir_all(folder.path().join("images")).unwrap();
    capture.write_binary(&folder, "sparse/0");
    assert!(refusal(folder.path()).starts_with("D: no folder of images; expected images, or"));
    let folder = capture.folder();
    folder.remove("images/a.png");
    folder.remove("images/b.png");
    assert!(refusal(folder.path()).starts_with("D/images/a.png: no such image (nor with .png"));
}

/// 10,000 models with a byte, a word or a length changed are read or refused in one line.
#[test]
fn mutations() {
    let mut capture = Capture::around();
    let fisheye = [8.0, 8.0, 4.0, 2.0, 0.1, -0.05, 0.01, -0.02, 0.02, -0.01, 0.03, -0.04];
    let second = Camera { id: 2, ..Capture::camera("THIN_PRISM_FISHEYE", &fisheye) };
    capture.cameras.push(second);
    capture.images[1].camera = 2;
    let folder = capture.folder();
    let names = ["cameras.bin", "images.bin", "points3D.bin"];
    let originals = capture.binary();
    let mut state = 1u64;
    // Knuth's linear congruential numbers.
    let mut number = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as usize % below
    };
    let (mut read, mut refused) = (0, 0);
    for i in 0..10_000 {
        let file = i % 3;
        let mut bytes = originals[file].clone();
        let at = number(bytes.len());
        match number(4) {
            0 => bytes[at] ^= 1 << number(8),
            1 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][number(5)],
            2 => {
                let end = bytes.len().min(at + 8);
                bytes[at..end].fill([0, 0xff, 0x7f][number(3)]);
            }
            _ => bytes.truncate(at),
        }
        folder.write(&format!("sparse/0/{}", names[file]), &bytes);
        match load(folder.path(), Split::Train, 1) {
            Ok(dataset) => {
                read += 1;
                let poses = dataset.views.iter().flat_map(|view| view.camera.camera_to_world);
                assert!(poses.into_iter().all(f32::is_finite), "{i}");
            }
            Err(error) => {
                refused += 1;
                let line = error.to_string();
                assert!(!line.contains('\n') && is_short(&line, folder.path()), "{i}: {line}");
            }
        }
        folder.write(&format!("sparse/0/{}", names[file]), &originals[file]);
    }
    assert!(read > 1000 && refused > 1000, "{read} {refused}");
}

fn is_short(line: &str, folder: &Path) -> bool {
    line.starts_with(&folder.display().to_string()) && line.len() < 600
}
