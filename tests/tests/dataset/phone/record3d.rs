//! Record3D's metadata.

use super::all;
use crate::fixture::{Folder, near, unit};
use crate::mutated::mutations;
use crate::refusals::refusal;

/// A quarter turn around y: ARKit's camera looks along -x with y up, right is -z.
const POSE: &str = "[0, 0.70710678, 0, 0.70710678, 1, 2, 3]";

fn metadata(more: &str) -> String {
    format!(
        r#"{{"K": [8, 0, 0, 0, 4, 0, 4, 6, 1], "w": 8, "h": 12,
        "poses": [{POSE}, {POSE}]{more}}}"#
    )
}

fn export(file: &str, images: &str, text: &str) -> Folder {
    let folder = Folder::new();
    folder.write(file, text);
    (0..2).for_each(|i| folder.image(&format!("{images}/{i}.jpg"), [4, 6], 9));
    folder
}

#[test]
fn a_hand_computed_ray() {
    for (file, images) in [("metadata", "rgbd"), ("metadata.json", "rgb")] {
        let dataset = all(&export(file, images, &metadata("")));
        assert_eq!((dataset.format, dataset.views.len()), ("record3d", 2));
        let view = &dataset.views[1];
        assert_eq!(view.name, format!("{images}/1.jpg"));
        // K is column after column, for images twice as large.
        assert_eq!((view.camera.focal, view.camera.center), ([4.0, 2.0], [2.0, 3.0]));
        // (x, y, z) of ARKit is (z, x, y) here: at (3, 1, 2), looking along -y, right is -x.
        let ray = view.ray(3.0, 4.0);
        assert!(near(ray.origin, [3.0, 1.0, 2.0]), "{ray:?}");
        assert!(near(ray.direction, unit([-0.25, -1.0, -0.5])), "{ray:?}");
    }
    let own = r#", "perFrameIntrinsicCoeffs": [[8, 4, 4, 6], [16, 12, 4, 6]]"#;
    let dataset = all(&export("metadata", "rgbd", &metadata(own)));
    assert_eq!(dataset.views[0].camera.focal, [4.0, 2.0]);
    assert_eq!(dataset.views[1].camera.focal, [8.0, 6.0]);
}

#[test]
fn partial_exports() {
    let hint = "; export the recording from Record3D as \"EXR + RGB sequence\" or unpack its .r3d \
                file, which is a zip archive";
    for (text, expected) in [
        (
            metadata("").replace("\"K\": [8, 0,", "\"K\": [8,"),
            "pose 0: \"K\" has 8 numbers, expected 9",
        ),
        (metadata("").replace("0.70710678, 1,", "0.70710678,"), {
            "pose 0: 6 numbers, expected 7: qx, qy, qz, qw, x, y, z"
        }),
        (metadata("").replace("0.70710678", "0"), "pose 0: a rotation of length 0, expected 1"),
        (
            metadata(r#", "perFrameIntrinsicCoeffs": [[8, 4, 4, 6]]"#),
            "pose 1: perFrameIntrinsicCoeffs has 0 numbers for it, expected 4",
        ),
        (metadata("").replace(POSE, ""), "\"poses\" is empty, expected one for each image"),
    ] {
        let text = text.replace("[, ]", "[]");
        let folder = export("metadata", "rgbd", &text);
        assert_eq!(refusal(folder.path()), format!("D/metadata: {expected}{hint}"));
    }
    let folder = export("metadata", "rgbd", &metadata(""));
    folder.remove("rgbd/0.jpg");
    folder.remove("rgbd/1.jpg");
    assert!(refusal(folder.path()).starts_with("D/rgbd/0: no such image"));
}

#[test]
fn a_long_video_is_thinned() {
    let poses = vec![POSE; 1300].join(", ");
    let text = metadata("").replace(&format!("{POSE}, {POSE}"), &poses);
    let folder = export("metadata", "rgbd", &text);
    let image = std::fs::read(folder.path().join("rgbd/0.jpg")).unwrap();
    (2..1300).for_each(|i| folder.write(&format!("rgbd/{i}.jpg"), &image));
    let dataset = all(&folder);
    assert_eq!((dataset.views.len(), dataset.views[1].name.as_str()), (600, "rgbd/3.jpg"));
    assert_eq!(dataset.notes, ["of 1300 frames of a video, 600 are used, evenly spread"]);
}

#[test]
fn damaged_files() {
    let own = r#", "perFrameIntrinsicCoeffs": [[8, 4, 4, 6], [16, 12, 4, 6]]"#;
    mutations(&export("metadata", "rgbd", &metadata(own)), &["metadata"], 10_000);
}
