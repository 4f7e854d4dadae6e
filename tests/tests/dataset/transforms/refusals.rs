//! What is wrong with a `transforms.json`, or with the images that it lists.

use pocketnerf_train::dataset::{LoadOptions, Split, inspect, load_with};

use super::{CAMERA, frames, scene, write};
use crate::fixture::Folder;
use crate::refusals::refusal;

#[test]
fn refusals() {
    let image = frames(&["a.png"], "");
    let with = |more: &str| frames(&["a.png"], more);
    let mirrored = image.replace("[1, 0, 0, 0]", "[-1, 0, 0, 0]");
    let top = |keys: &str| format!("{CAMERA}, {keys}");
    let file = "D/transforms.json";
    let unreadable = |what: &str| format!("{file}: {what} cannot be read; ");
    let frame = |problem: &str| format!("{file}: frame 0 (\"a.png\"): {problem}");
    let box_of = |key: &str| format!("{file}: \"{key}\" makes no box, expected ");
    for (camera, frames, start) in [
        (CAMERA.to_owned(), String::new(), format!("{file}: \"frames\" is empty")),
        (CAMERA.to_owned(), "3".to_owned(), format!("{file}:2:12: invalid type: integer `3`")),
        ("\"w\": 8, \"h\": 4".to_owned(), image.clone(), frame("no focal length, expected fl_x")),
        ("\"fl_x\": 0".to_owned(), image.clone(), frame("fl_x is 0, expected pixels above 0")),
        ("\"x_fov\": 180".to_owned(), image.clone(), frame("x_fov is 180, expected degrees")),
        ("\"camera_angle_x\": 40".to_owned(), image.clone(), frame("camera_angle_x is 40, exp")),
        ("\"fl_x\": 4, \"w\": 8".to_owned(), image.clone(), frame("w is 8 and h is nothing")),
        ("\"fl_x\": 4, \"cx\": 1e30".to_owned(), image.clone(), frame("the principal point is")),
        (CAMERA.to_owned(), mirrored, frame("the pose's 3x3 part is not a rotation")),
        (
            CAMERA.to_owned(),
            image.replace("-4", "NaN"),
            format!("{file}:2:81: a number is not fin"),
        ),
        (CAMERA.to_owned(), image.replace("-4", "1e300"), frame("the pose holds a number that")),
        (
            CAMERA.to_owned(),
            r#"{"file_path": "a.png"}"#.to_owned(),
            frame("no transform_matrix, expected 4 rows"),
        ),
        (
            CAMERA.to_owned(),
            r#"{"file_path": "a.png", "transform_matrix_start": [], "transform_matrix_end": []}"#
                .to_owned(),
            unreadable("\"transform_matrix_start\""),
        ),
        (
            top("\"camera_model\": \"FISHEYE624\""),
            image.clone(),
            unreadable("camera_model \"FISHEYE624\""),
        ),
        (top("\"ftheta_p0\": 1"), image.clone(), unreadable("\"ftheta_p0\"")),
        (top("\"equirectangular\": true"), image.clone(), unreadable("\"equirectangular\"")),
        (top("\"orthographic\": true"), image.clone(), unreadable("\"orthographic\"")),
        (
            CAMERA.to_owned(),
            with(r#", "rolling_shutter": [0, 0, 1, 0]"#),
            unreadable("\"rolling_shutter\""),
        ),
        (
            top("\"is_fisheye\": true, \"p1\": 0.1"),
            image.clone(),
            unreadable("a fisheye lens with p1 and p2"),
        ),
        (top("\"from_mitsuba\": true"), image.clone(), unreadable("\"from_mitsuba\"")),
        (top("\"white_transparent\": true"), image.clone(), unreadable("\"white_transparent\"")),
        (
            top("\"distortion_params\": [1]"),
            image.clone(),
            frame("distortion_params has 1 numbers, expected 6"),
        ),
        (top("\"aabb_scale\": 0"), image.clone(), box_of("aabb_scale")),
        (top("\"aabb_scale\": 256"), image.clone(), box_of("aabb_scale")),
        (top("\"scale\": 0"), image.clone(), box_of("scale")),
        (top("\"offset\": [1, 2]"), image.clone(), box_of("offset")),
        (top("\"aabb\": [[0, 0, 0], [0, 1, 1]]"), image.clone(), box_of("aabb")),
        (
            top("\"train_filenames\": [\"c.png\"]"),
            image.clone(),
            format!("{file}: train_filenames lists \"c.png\", which no frame has"),
        ),
        (
            top("\"test_filenames\": [\"a.png\"]"),
            image.clone(),
            format!("{file}: no train images: it lists test"),
        ),
        (
            CAMERA.to_owned(),
            image.replace("a.png", "gone"),
            "D/gone: no such image (nor with .png, .jpg and the like added); D/transforms.json lists 1"
                .to_owned(),
        ),
        (
            CAMERA.to_owned(),
            image.clone(),
            format!("{file}: no train images: it has 1, of which one in 8 is held out"),
        ),
    ] {
        let folder = scene(CAMERA, &["a.png"]);
        write(&folder, &camera, &frames);
        let message = refusal(folder.path());
        assert!(message.starts_with(&start), "{camera}: {message}, expected {start}");
    }
}

#[test]
fn images_that_do_not_fit() {
    let message = |folder: &Folder| {
        let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
        let error = load_with(folder.path(), Split::Train, &options).unwrap_err().to_string();
        assert!(!error.contains('\n'));
        error.replace(&folder.path().display().to_string(), "D")
    };
    let folder = scene(CAMERA, &["a.png", "b.png"]);
    folder.image("a.png", [4, 4], 0);
    assert!(
        message(&folder).starts_with("D/a.png: 4x4 pixels, but its camera is for 8x4; expected")
    );
    let report = inspect(folder.path()).unwrap();
    assert_eq!(report.splits[1].images_misshapen, ["a.png"]);
    // Both fit their camera, but it is one camera.
    folder.image("a.png", [8, 4], 0);
    assert!(
        message(&folder).starts_with("D/b.png: 4x2 pixels, but D/a.png has 8x4; expected images")
    );
    let folder = scene(CAMERA, &["a.png"]);
    let masked = frames(&["a.png"], r#", "mask_path": "mask.png""#);
    write(&folder, CAMERA, &masked);
    assert!(message(&folder).starts_with("D/mask.png: unreadable image: "));
    assert_eq!(inspect(folder.path()).unwrap().splits[0].masks_missing, ["mask.png"]);
    folder.image("mask.png", [8, 4], 0);
    assert!(message(&folder).starts_with("D/mask.png: 8x4 pixels, but D/a.png has 4x2; expected"));
    folder.pixels("mask.png", [4, 2], |_, _| [0; 3]);
    assert!(
        message(&folder).starts_with("D/a.png: its mask or lens leaves no pixel to learn from")
    );
    let options = LoadOptions { spherify: true, ..LoadOptions::default() };
    let error = load_with(folder.path(), Split::Train, &options).unwrap_err().to_string();
    assert!(error.ends_with(
        "--spherify is for LLFF captures (poses_bounds.npy), which this is not; leave it out"
    ));
}
