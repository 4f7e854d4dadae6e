//! The default camera of a model.

use pocketnerf_formats::{About, Precision, open, write};
use pocketnerf_tests::tiny::{self, Tiny};

#[test]
fn a_file_without_a_view_is_seen_from_aside_and_above() {
    let tiny = Tiny::new();
    let about = About { camera: None, ..tiny::about() };
    let bytes = write(&tiny.hash_grid(), &about, Precision::F16).unwrap();
    let file = open(&bytes).unwrap();
    let camera = file.camera(40, 30);
    camera.validate().unwrap();
    // The middle of the scene is in the middle of the picture.
    let [x, y] = camera.project(file.model.space.center()).unwrap();
    assert!((x - 20.0).abs() < 1e-3 && (y - 15.0).abs() < 1e-3, "{x} {y}");
    // In the dataset's coordinates, which are turned: along x, above, and level.
    let scene = &file.about.scene;
    let pose = scene.camera_to_dataset(&camera).camera_to_world;
    let middle = scene.to_dataset(file.model.space.center());
    let away = [0, 1, 2].map(|a| pose[4 * a + 3] - middle[a]);
    assert!(away[0] > 0.0 && away[1].abs() < 1e-4 * away[0], "{away:?}");
    assert!((away[2] / away[0] - 0.5f32.tan()).abs() < 1e-4, "{away:?}");
    assert!(pose[8].abs() < 1e-4 && pose[9] > 0.0, "{pose:?}");
}

#[test]
fn a_file_with_a_view_of_its_own_is_seen_like_that() {
    let bytes = include_bytes!("../../golden/hash-grid-f16.pnerf");
    let file = open(bytes).unwrap();
    let own = file.about.camera.unwrap();
    assert_eq!(file.camera(own.width, own.height), own.camera());
}

#[test]
fn a_forward_facing_capture_is_seen_from_where_it_was_taken() {
    let tiny = Tiny::new();
    let about = About { camera: None, ..About::default() };
    let bytes = write(&tiny.ndc(), &about, Precision::F16).unwrap();
    let camera = open(&bytes).unwrap().camera(40, 30);
    camera.validate().unwrap();
    assert_eq!((camera.position(), camera.axis()), ([0.0; 3], [0.0, 0.0, -1.0]));
}
