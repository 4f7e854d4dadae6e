//! `pocketnerf eval --fit-poses`.

use glam::{Mat3, Mat4, Vec3};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{self, Split, View};
use serde_json::Value;

use crate::place::{Place, text};

/// What a pose is off by: radians about an axis of the camera's own, and scene units.
const OFF: [(Vec3, f32, Vec3); 3] = [
    (Vec3::X, 0.02, Vec3::new(0.03, 0.0, 0.02)),
    (Vec3::Y, -0.025, Vec3::new(0.0, -0.04, 0.0)),
    (Vec3::Z, 0.03, Vec3::new(-0.02, 0.02, 0.03)),
];

#[test]
fn poses_that_are_off_are_found_again() {
    let place = Place::new();
    let mut views = builtin::dataset(Split::Test, 2).views;
    views.truncate(OFF.len());
    let write = |folder: &str, views: &[View]| {
        std::fs::create_dir(place.path(folder)).unwrap();
        dataset::write(&place.path(folder), Split::Test, views).unwrap();
    };
    write("right", &views);
    for (view, (axis, angle, shift)) in views.iter_mut().zip(OFF) {
        let pose = Mat4::from_cols_array(&view.camera.camera_to_world).transpose();
        let mut turned = pose * Mat4::from_mat3(Mat3::from_axis_angle(axis, angle));
        turned.w_axis += shift.extend(0.0);
        view.camera.camera_to_world = turned.transpose().to_cols_array();
    }
    write("off", &views);
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../../embed-demo/still-life.pnerf");
    let eval = |data: &str, more: &str| place.ok(&format!("eval {model} {data} --json {more}"));
    let psnr = |result: &Value| result["psnr"].as_f64().unwrap();
    let [right, off, fitted] = [eval("right", ""), eval("off", ""), eval("off", "--fit-poses")];
    assert!(psnr(&off) < psnr(&right) - 6.0, "{} {}", psnr(&off), psnr(&right));
    // Six numbers may gain a little more than the error of the poses.
    let gain = psnr(&fitted) - psnr(&right);
    assert!((-0.05..0.3).contains(&gain), "{} {}", psnr(&fitted), psnr(&right));
    for (view, (_, angle, shift)) in fitted["per_view"].as_array().unwrap().iter().zip(OFF) {
        let found = |figure: &str| view["pose_correction"][figure].as_f64().unwrap() as f32;
        assert!((found("degrees") - angle.abs().to_degrees()).abs() < 0.15, "{view}");
        assert!((found("shift") - shift.length()).abs() < 0.01, "{view}");
    }
    assert_eq!((&right["fit_poses"], &fitted["fit_poses"]), (&false.into(), &true.into()));
    assert!(right["per_view"][0]["pose_correction"].is_null());

    // Photographs that are darker than the scene, too: poses are found by what they show.
    for view in &mut views {
        view.rgba.chunks_exact_mut(4).for_each(|p| p[..3].iter_mut().for_each(|v| *v -= *v / 4));
    }
    write("dark", &views);
    let dark = eval("dark", "--fit-poses --fit-exposure");
    for view in 0..OFF.len() {
        let degrees = |result: &Value| {
            result["per_view"][view]["pose_correction"]["degrees"].as_f64().unwrap()
        };
        assert!((degrees(&dark) - degrees(&fitted)).abs() < 0.1, "{view}");
    }
    let output = place.run(&format!("eval {model} off --fit-poses"));
    let line = text(&output.stdout);
    let degrees = fitted["per_view"].as_array().unwrap().iter();
    let degrees = degrees.map(|view| view["pose_correction"]["degrees"].as_f64().unwrap());
    let mean = degrees.sum::<f64>() / OFF.len() as f64;
    assert!(line.contains(&format!("; poses fitted: turned by {mean:.3} degrees")), "{line}");
}
