//! Files as other programs write them, and files that are wrong.

use super::*;

fn read(text: &str, size: Option<[u32; 2]>) -> Result<Vec<Camera>, String> {
    path(text, Wanted { size, ..Wanted::default() }).map(|path| path.cameras)
}

fn path(text: &str, wanted: Wanted) -> Result<CameraPath, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("path.json");
    std::fs::write(&file, text).unwrap();
    camera_path(&file, wanted).map_err(|error| {
        let error = error.to_string();
        error.split_once("path.json").expect("the file is named").1.to_owned()
    })
}

const FLAT: &str = "[1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1]";
const ROWS: &str = "[[1,0,0,5],[0,1,0,6],[0,0,1,7],[0,0,0,1]]";

#[test]
fn nerfstudio_angles_are_vertical() {
    let text = format!(
        r#"{{"camera_type": "perspective", "render_width": 80, "render_height": 60.0, "fps": 24,
            "camera_path": [{{"camera_to_world": {FLAT}, "fov": 90, "aspect": 1}}]}}"#
    );
    let cameras = read(&text, None).unwrap();
    // 90° high, 60 pixels: focal 30.
    let camera = &cameras[0];
    assert_eq!((cameras.len(), camera.width, camera.height), (1, 80, 60));
    assert!((camera.focal[0] - 30.0).abs() < 1e-4 && camera.focal[0] == camera.focal[1]);
    assert_eq!((camera.center, camera.position()), ([40.0, 30.0], [5.0, 6.0, 7.0]));
    let other = &read(&text, Some([20, 20])).unwrap()[0];
    assert!((other.focal[0] - 10.0).abs() < 1e-4 && other.width == 20);
}

#[test]
fn keyframes_become_as_many_cameras_as_the_file_asks_for() {
    let moved = FLAT.replace(",0,5,", ",0,7,");
    let text = |more: &str| {
        format!(
            r#"{{"render_width": 80, "render_height": 60, {more} "keyframes": [
                {{"matrix": {FLAT}, "fov": 50, "aspect": 1}},
                {{"matrix": {moved}, "fov": 90, "override_transition_enabled": false}}]}}"#
        )
    };
    let found = path(&text(r#""fps": 10, "seconds": 3.0,"#), Wanted::default()).unwrap();
    assert_eq!((found.cameras.len(), found.fps), (30, Some(10.0)));
    let ends = [found.cameras[0], found.cameras[29]];
    assert_eq!(ends.map(|camera| camera.position()), [[5.0, 6.0, 7.0], [7.0, 6.0, 7.0]]);
    assert!((ends[1].focal[1] - 30.0).abs() < 1e-4);
    // Two seconds from one to the next, thirty pictures each, unless somebody says otherwise.
    let found = path(&text(""), Wanted::default()).unwrap();
    assert_eq!((found.cameras.len(), found.fps), (60, None));
    let wanted = Wanted { fps: Some(24.0), seconds: Some(0.5), ..Wanted::default() };
    let found = path(&text(r#""default_transition_sec": 7,"#), wanted).unwrap();
    assert_eq!((found.cameras.len(), found.fps), (12, Some(24.0)));
    // What nerfstudio has interpolated itself is taken as it is.
    let camera = format!(r#""camera_path": [{{"camera_to_world": {FLAT}, "fov": 60}}],"#);
    assert_eq!(path(&text(&camera), Wanted::default()).unwrap().cameras.len(), 1);
}

#[test]
fn matrices_as_text_are_columns() {
    let columns = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]";
    let text = format!(r#"{{"keyframes": [{{"matrix": "{columns}", "fov": 50}}]}}"#);
    assert_eq!(read(&text, Some([8, 8])).unwrap()[0].position(), [5.0, 6.0, 7.0]);
}

#[test]
fn instant_ngp_keyframes_are_in_its_cube() {
    let text = r#"{"loop": true, "time": 0.5, "path": [
        {"R": [0, 0, 0, 1], "T": [0.5, 0.5, 0.83], "fov": 50, "scale": 1.5, "slice": 0},
        {"R": [0, 0, 0, 1], "T": [0.5, 0.83, 0.5], "fov": 50, "scale": 1.5, "slice": 0}]}"#;
    let cameras = read(text, Some([8, 8])).unwrap();
    // There and back, two seconds each.
    assert_eq!(cameras.len(), 120);
    for (i, expected) in [(0, [1.0, 0.0, 0.0]), (60, [0.0, 0.0, 1.0])] {
        let position = cameras[i].position();
        assert!(position.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{position:?}");
    }
}

#[test]
fn transforms_angles_are_horizontal() {
    let text = format!(
        r#"{{"camera_angle_x": {}, "frames": [{{"transform_matrix": {ROWS}, "file_path": "a"}}]}}"#,
        std::f64::consts::FRAC_PI_2
    );
    let camera = &read(&text, Some([80, 60])).unwrap()[0];
    assert!((camera.focal[1] - 40.0).abs() < 1e-4, "{camera:?}");
    assert_eq!(
        read(&text, None).unwrap_err(),
        ": picture size missing, expected 1x1 to 65536x65536; give --width and --height"
    );
}

#[test]
fn what_is_wrong_is_said() {
    let size = Some([8, 8]);
    for (text, message) in [
        ("{}", ": no camera path: none of"),
        ("[]", ":1:0: invalid type: sequence, expected a map; expected a JSON object"),
        (r#"{"camera_path": []}"#, ": no cameras in it"),
        (r#"{"keyframes": []}"#, ": no cameras in it"),
        (r#"{"path": []}"#, ": no cameras in it"),
        (r#"{"path": [{"R": [0, 0, 0, 1]}]}"#, ":1:29: missing field `T`"),
        (r#"{"keyframes": [{"matrix": "[1]", "fov": 50}]}"#, ": camera 0: the pose has 1"),
        (r#"{"camera_path": 3}"#, ":1:17: invalid type: integer"),
        (r#"{"camera_path": [], "camera_type": "fisheye"}"#, ": camera type \"fisheye\""),
        (r#"{"frames": []}"#, ": camera 0: field of view missing"),
        (r#"{"frames": [{"transform_matrix": []}], "camera_angle_x": 1}"#, ": camera 0: the pose"),
    ] {
        let error = read(text, size).unwrap_err();
        assert!(error.starts_with(message), "{error}");
    }
    let error = read(r#"{"keyframes": [{"matrix": 3, "fov": 50}]}"#, size).unwrap_err();
    assert!(error.starts_with(":1:") && error.contains(": 16 numbers; expected"), "{error}");
    let path = format!(
        r#""keyframes": [{{"matrix": {FLAT}, "fov": 50}}, {{"matrix": {FLAT}, "fov": 50}}]"#
    );
    for timing in [r#""seconds": -1"#, r#""fps": 1e9"#, r#""default_transition_sec": 0"#] {
        let error = read(&format!("{{{timing}, {path}}}"), size).unwrap_err();
        assert!(error.contains(" seconds of ") && error.contains("expected"), "{error}");
    }
    let wide = format!(r#"{{"camera_path": [{{"camera_to_world": {FLAT}, "fov": 180}}]}}"#);
    assert!(read(&wide, size).unwrap_err().starts_with(": camera 0: field of view 180"));
    assert!(read(&wide, Some([0, 8])).unwrap_err().starts_with(": picture size 0x8"));
}
