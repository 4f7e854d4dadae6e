//! 3d Scanner App's frames.

use super::all;
use crate::fixture::{Folder, near, unit};
use crate::mutated::mutations;
use crate::refusals::refusal;

/// As [`super::polycam`]'s camera.
const CAMERA: &str = r#"{"cameraPoseARFrame": [0, 0, 1, 1, 0, 1, 0, 2, -1, 0, 0, 3, 0, 0, 0, 1],
    "intrinsics": [8, 0, 4, 0, 4, 2, 0, 0, 1], "motionQuality": 1, "frame_index": 0}"#;

fn export() -> Folder {
    let folder = Folder::new();
    for i in 0..4 {
        folder.write(&format!("frame_0000{i}.json"), CAMERA);
    }
    folder.write("info.json", "{}");
    folder.image("frame_00000.jpg", [8, 4], 9);
    folder.image("frame_00003.jpg", [8, 4], 9);
    folder
}

#[test]
fn a_hand_computed_ray() {
    let dataset = all(&export());
    assert_eq!((dataset.format, dataset.views.len()), ("3d-scanner-app", 2));
    assert_eq!(dataset.notes, ["2 of 4 frames have an image"]);
    // Phones measure in metres, and what they call up is up as it is read.
    let world = pocketnerf_formats::World { up: None, metres: Some(1.0) };
    assert_eq!((dataset.scene().scale, dataset.world()), (1.0, world));
    let view = &dataset.views[1];
    assert_eq!(view.name, "frame_00003.jpg");
    assert_eq!((view.camera.focal, view.camera.center), ([8.0, 4.0], [4.0, 2.0]));
    // At (3, 1, 2), looking along -y with z up, right is -x.
    let ray = view.ray(6.0, 3.0);
    assert!(near(ray.origin, [3.0, 1.0, 2.0]), "{ray:?}");
    assert!(near(ray.direction, unit([-0.25, -1.0, -0.25])), "{ray:?}");
}

#[test]
fn partial_exports() {
    let hint = "; export the scan from 3d Scanner App as \"All Data\"";
    let folder = export();
    folder.remove("frame_00000.jpg");
    folder.remove("frame_00003.jpg");
    assert_eq!(refusal(folder.path()), format!("D: 4 frames, but no image of any{hint}"));
    let folder = export();
    folder.image("frame_00000.jpg", [4, 8], 9);
    assert_eq!(
        refusal(folder.path()),
        format!(
            "D/frame_00000.json: its principal point is at (4, 2), but its image has 4x8 pixels: \
             turned or made smaller{hint}"
        )
    );
    let folder = export();
    folder.write("frame_00003.json", CAMERA.replace("[8, 0, 4, 0, 4, 2, 0, 0, 1]", "[8, 0, 4]"));
    assert_eq!(
        refusal(folder.path()),
        format!("D/frame_00003.json: intrinsics has 3 numbers, expected 9{hint}")
    );
}

#[test]
fn damaged_files() {
    mutations(&export(), &["frame_00003.json"], 10_000);
}
