//! Polycam's raw data.

use super::all;
use crate::fixture::{Folder, near, unit};
use crate::mutated::mutations;
use crate::refusals::refusal;

/// A camera at (1, 2, 3) in ARKit's world, y up, that looks along -x with y up: right is -z,
/// back is +x.
fn camera(more: &str) -> String {
    format!(
        r#"{{"t_00": 0, "t_01": 0, "t_02": 1, "t_03": 1,
        "t_10": 0, "t_11": 1, "t_12": 0, "t_13": 2,
        "t_20": -1, "t_21": 0, "t_22": 0, "t_23": 3,
        "fx": 64, "fy": 32, "cx": 64, "cy": 32, "width": 128, "height": 64,
        "timestamp": 12{more}}}"#
    )
}

fn export(cameras: &str, images: &str) -> Folder {
    let folder = Folder::new();
    for (name, more) in [("101", ""), ("102", r#", "blur_score": 24.9"#), ("103", "")] {
        folder.write(&format!("keyframes/{cameras}/{name}.json"), camera(more));
        folder.image(&format!("keyframes/{images}/{name}.jpg"), [64, 32], 7);
    }
    folder
}

#[test]
fn a_hand_computed_ray() {
    let folder = export("corrected_cameras", "corrected_images");
    let dataset = all(&folder);
    assert_eq!(dataset.format, "polycam");
    let names: Vec<_> = dataset.views.iter().map(|view| view.name.as_str()).collect();
    let images = "keyframes/corrected_images";
    assert_eq!(names, [format!("{images}/101.jpg"), format!("{images}/103.jpg")]);
    let view = &dataset.views[0];
    // Images half as large as the camera says.
    assert_eq!((view.camera.focal, view.camera.center), ([32.0, 16.0], [32.0, 16.0]));
    // (x, y, z) of ARKit is (z, x, y) here: at (3, 1, 2), looking along -y with z up, right is -x.
    // 8 pixels right of the middle and 4 below it.
    let ray = view.ray(40.0, 20.0);
    assert!(near(ray.origin, [3.0, 1.0, 2.0]), "{ray:?}");
    assert!(near(ray.direction, unit([-0.25, -1.0, -0.25])), "{ray:?}");
    // A sixty-fourth of the width along the edges, a pixel, does not count.
    let mask = view.mask.as_ref().unwrap();
    assert_eq!(mask.iter().filter(|counts| **counts != 0).count(), 62 * 30);
    assert_eq!((mask[64], mask[65], mask[65 + 62]), (0, 255, 0));
    let said = "1 of 3 images are blurred (blur_score below 25): they are left out";
    assert!(dataset.notes.iter().any(|note| note == said), "{:?}", dataset.notes);
    // The folder itself is as good.
    let inside = pocketnerf_train::dataset::load(
        &folder.path().join("keyframes"),
        pocketnerf_train::dataset::Split::Test,
        1,
    );
    assert_eq!(inside.unwrap().views[0].name, "corrected_images/101.jpg");
}

#[test]
fn uncorrected_images() {
    let dataset = all(&export("cameras", "images"));
    assert!(dataset.views[0].mask.is_none());
    assert!(dataset.notes[0].starts_with("no corrected_cameras: poses are as the phone tracked"));
}

#[test]
fn partial_exports() {
    let hint = "turn on Developer Mode in Polycam's settings, process the capture, and export its \
                Raw Data";
    let folder = Folder::new();
    folder.image("keyframes/images/101.jpg", [64, 32], 7);
    assert_eq!(
        refusal(folder.path()),
        format!(
            "D/keyframes/: no images with cameras, expected corrected_images and \
             corrected_cameras; {hint}"
        )
    );
    folder.write("keyframes/cameras/notes.txt", "");
    assert_eq!(
        refusal(folder.path()),
        format!("D/keyframes/cameras: no camera, expected a JSON file for each image; {hint}")
    );
    let folder = export("cameras", "images");
    let file = "keyframes/cameras/101.json";
    for (text, expected) in [
        (camera("").replace("\"fx\": 64", "\"fx\": 0"), "its focal length is 0, expected pixels"),
        (camera("").replace("\"t_11\": 1", "\"t_11\": 2"), "the pose's 3x3 part is not a rotation"),
        (camera("").replace("\"width\": 128", "\"width\": 0"), "0x64 pixels, expected 1x1 to"),
    ] {
        folder.write(file, text);
        let message = refusal(folder.path());
        assert!(message.starts_with(&format!("D/{file}: {expected}")), "{message}");
        assert!(message.ends_with(hint), "{message}");
    }
    folder.write(file, camera("").replace("t_23", "t_24"));
    let message = refusal(folder.path());
    assert!(message.starts_with(&format!("D/{file}:5:")), "{message}");
    assert!(message.contains("missing field `t_23`"), "{message}");
}

#[test]
fn damaged_files() {
    let folder = export("cameras", "images");
    mutations(&folder, &["keyframes/cameras/101.json", "keyframes/cameras/103.json"], 10_000);
}
