//! Many pictures: circles, and paths among photographs.

use pocketnerf_train::picture::image_file;
use serde_json::Value;

use super::MODEL;
use crate::place::{Place, TRAIN};

/// The circle that options ask for, picture by picture against poses worked out by hand.
#[test]
fn a_circle_as_it_is_asked_for() {
    let place = Place::new();
    let size = "--width 40 --height 30 --fov 50";
    let circle = "--orbit 3 --center 0.1,-0.2,0.3 --radius 3 --elevation 0 --arc 0,180";
    place.ok(&format!("render {MODEL} {size} {circle} --ease --out circle"));
    let spiral = circle.replace("--elevation 0 --arc 0,180", "--elevation 0,30 --arc 0,720");
    place.ok(&format!("render {MODEL} {size} {spiral} --out spiral"));
    // From x, y and -x, three units away, upright; half way up after a turn, and 30 degrees up.
    for (picture, pose) in [
        ("circle/000.png", "[0,0,1,3.1, 1,0,0,-0.2, 0,1,0,0.3, 0,0,0,1]"),
        ("circle/001.png", "[-1,0,0,0.1, 0,0,1,2.8, 0,1,0,0.3, 0,0,0,1]"),
        ("circle/002.png", "[0,0,-1,-2.9, -1,0,0,-0.2, 0,1,0,0.3, 0,0,0,1]"),
        ("spiral/000.png", "[0,0,1,3.1, 1,0,0,-0.2, 0,1,0,0.3, 0,0,0,1]"),
        (
            "spiral/001.png",
            "[0,-0.258819,0.965926,2.997777, 1,0,0,-0.2, 0,0.965926,0.258819,1.076457, 0,0,0,1]",
        ),
        ("spiral/002.png", "[0,-0.5,0.866025,2.698076, 1,0,0,-0.2, 0,0.866025,0.5,1.8, 0,0,0,1]"),
    ] {
        let mut command = place.command(&format!("render {MODEL} {size} --out one.png"));
        assert!(command.args(["--pose", pose]).output().unwrap().status.success());
        let open = |name: &str| image_file::open(place.path(name)).unwrap().to_rgb8().into_raw();
        let [circle, one] = [open(picture), open("one.png")];
        let far = circle.iter().zip(&one).filter(|(a, b)| a.abs_diff(**b) > 2).count();
        assert!(far < 12, "{picture}: {far} of {}", one.len());
    }
    for (options, expected) in [
        ("--radius 0", "--radius 0: expected more than 0, and less than 1e6"),
        ("--elevation 90", "--elevation 90: expected less than 90 degrees up or down"),
        ("--elevation 0,95", "--elevation 95: expected less than 90 degrees up or down"),
        ("--orbit 0", "--orbit 0: expected 1 to 10000 views"),
    ] {
        assert_eq!(place.line(&format!("render {MODEL} {options} --out x")), expected);
    }
    for options in
        ["--center 1,2", "--arc 3", "--radius x", "--arc 0,90 --pose [1]", "--ease --pose [1]"]
    {
        assert_eq!(place.run(&format!("render {MODEL} {options}")).status.code(), Some(2));
    }
}

/// A trained model says where its photographs were taken, and a path stays there.
#[test]
fn a_path_among_the_photographs() {
    let place = Place::new();
    place.ok(&format!("{TRAIN} --steps 3 --out x.pnerf"));
    let info = place.ok("info x.pnerf --json");
    assert_eq!(info["photographs"], 12);
    let sections = info["sections"].as_array().unwrap();
    let found = sections.iter().find(|section| section["kind"] == "PHOTOGRAPHS").unwrap();
    // Focal length, bounds, a length of two bytes, and twelve bytes a photograph.
    assert_eq!(found["bytes"], 4 + 24 + 2 + 12 * 12);
    // The path is not the circle.
    let size = "--width 20 --height 15";
    let path = place.ok(&format!("render x.pnerf {size} --orbit 8 --json --out path"));
    assert_eq!((&path["pictures"], &path["video"]), (&8.into(), &Value::Null));
    place.ok(&format!("render x.pnerf {size} --orbit 8 --elevation 28.6479 --out circle"));
    let differ =
        |name: &str| place.bytes(&format!("path/{name}")) != place.bytes(&format!("circle/{name}"));
    assert!(differ("000.png") && differ("005.png"));
    // It stays with the model.
    place.ok("repack x.pnerf re.pnerf");
    place.ok("convert x.pnerf f16.pnerf --precision f16");
    for model in ["re.pnerf", "f16.pnerf"] {
        assert_eq!(place.ok(&format!("info {model} --json"))["photographs"], 12, "{model}");
    }
    assert_eq!(place.ok(&format!("info {MODEL} --json"))["photographs"], Value::Null);
}

/// A path through keyframes ends where a picture of the last one is.
#[test]
fn a_path_through_keyframes() {
    let place = Place::new();
    let pose = "[0,0,1,3.1, 1,0,0,-0.2, 0,1,0,0.3, 0,0,0,1]";
    let last = pose.replace("3.1", "4.1");
    let keyframes = format!(
        r#"{{"keyframes": [{{"matrix": {pose}, "fov": 40}}, {{"matrix": {last}, "fov": 40}}],
            "render_width": 40, "render_height": 30, "fps": 2, "seconds": 1.5}}"#
    );
    std::fs::write(place.path("path.json"), keyframes).unwrap();
    let render = format!("render {MODEL} --camera-path path.json --json --out path");
    let result = place.ok(&render);
    assert_eq!((&result["pictures"], &result["width"]), (&3.into(), &40.into()));
    // 40 degrees high are 51.77 wide.
    let mut command =
        place.command(&format!("render {MODEL} --width 40 --height 30 --out one.png"));
    let fov = 2.0 * (40.0 / 30.0 * 20f64.to_radians().tan()).atan().to_degrees();
    let pose = ["--pose", &last, "--fov", &fov.to_string()];
    assert!(command.args(pose).output().unwrap().status.success());
    let open = |name: &str| image_file::open(place.path(name)).unwrap().to_rgb8().into_raw();
    let far = |name: &str| {
        let pairs = open(name).into_iter().zip(open("one.png"));
        pairs.filter(|(a, b)| a.abs_diff(*b) > 2).count()
    };
    assert!(far("path/002.png") < 12 && far("path/000.png") > 100, "{}", far("path/002.png"));
    assert_eq!(place.ok(&format!("{render} --seconds 3 --fps 4"))["pictures"], 12);
    let alone = place.run(&format!("render {MODEL} --seconds 3"));
    assert_eq!(alone.status.code(), Some(2));
}
