//! `pocketnerf convert`.

use std::path::Path;
use std::process::{Command, Output};

use pocketnerf_train::picture::image_file;
use serde_json::Value;

/// Small models of TensoRF and svox2.
const VOLUMES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures/volumes/");
const FIXTURES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures/ngp/");

fn pocketnerf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pocketnerf")).args(arguments).output().unwrap()
}

#[track_caller]
fn done(arguments: &[&str]) -> Value {
    let output = pocketnerf(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_default()
}

/// The one line that says why not.
#[track_caller]
fn refused(arguments: &[&str]) -> String {
    let output = pocketnerf(arguments);
    assert!(!output.status.success());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    said
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A snapshot's first camera is the model's own, and a pose in the dataset's coordinates
/// shows the same.
#[test]
fn poses_are_in_the_coordinates_of_the_dataset() {
    let folder = tempfile::tempdir().unwrap();
    let [model, own, posed] =
        ["model.pnerf", "own.png", "posed.png"].map(|name| folder.path().join(name));
    let source = format!("{FIXTURES}cutlass.ingp");
    let said = done(&["convert", &source, text(&model), "--verify", "--json"]);
    assert_eq!(said["program"], "NVlabs/instant-ngp");
    assert!(said["verify_occupancy"]["psnr"].as_f64().unwrap() > 70.0, "{said}");
    let about = std::fs::read(format!("{FIXTURES}cutlass.json")).unwrap();
    let about: Value = serde_json::from_slice(&about).unwrap();
    let mut pose = about["cameras"][0]["camera_to_world"].clone();
    pose.as_array_mut().unwrap().push(serde_json::json!([0, 0, 0, 1]));
    done(&["render", text(&model), "--out", text(&own)]);
    done(&["render", text(&model), "--pose", &pose.to_string(), "--out", text(&posed)]);
    let [own, posed] = [own, posed].map(|path| image_file::open(path).unwrap().to_rgb8());
    assert_eq!(own.dimensions(), (64, 48));
    let apart = own.as_raw().iter().zip(posed.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(apart.unwrap() <= 1, "{apart:?}");
    assert!(own.as_raw().iter().any(|value| *value != own.as_raw()[0]), "something to see");
}

#[test]
fn what_cannot_be_converted_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.pnerf");
    let fixture = |name: &str| format!("{FIXTURES}{name}");
    let said = refused(&["convert", &fixture("torch/torch_ngp.pth"), text(&out)]);
    assert!(said.contains("torch_ngp.pth") && said.contains("--background"), "{said}");
    let said = refused(&["convert", &fixture("fused.msgpack"), text(&out), "--samples", "64,64"]);
    assert!(said.contains("fused.msgpack") && said.contains("--samples"), "{said}");
    let cut = folder.path().join("cut.ingp");
    let whole = std::fs::read(fixture("cutlass.ingp")).unwrap();
    std::fs::write(&cut, &whole[..whole.len() / 2]).unwrap();
    let said = refused(&["convert", text(&cut), text(&out)]);
    assert!(said.contains("cut.ingp") && said.contains("unpacked"), "{said}");
    let tensorf = folder.path().join("tensorf.th");
    std::fs::write(&tensorf, [&b"PK\x03\x04"[..], &[0; 40], b"density_plane.0"].concat()).unwrap();
    assert!(refused(&["convert", text(&tensorf), text(&out)]).contains("tensorf.th"));
    assert!(!out.exists());
}

/// What no kind of field holds becomes a hash grid that learns from its pictures, in the dataset's
/// coordinates.
#[test]
fn volumes_are_learnt_from() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("learnt.pnerf");
    for (file, program, side, scale) in [
        ("harmonics.th", "apchenstu/TensoRF", [-1.2, 0.8], 1.0),
        ("nine.npz", "sxyu/svox2", [-0.9, 1.1], 1.5),
    ] {
        let file = format!("{VOLUMES}{file}");
        let how = ["--distill-to", "800000", "--distill-seconds", "4", "--json", "--quiet"];
        let result = done(&[&["convert", &file, text(&out)][..], &how].concat());
        assert_eq!(result["program"], program);
        let bytes = std::fs::metadata(&out).unwrap().len();
        assert_eq!(result["bytes"], bytes);
        assert!(bytes <= 800_000);
        let learnt = &result["verify_occupancy"];
        // A fog of random colours, from all sides, after a few seconds.
        assert!(learnt["psnr"].as_f64().unwrap() > 15.0, "{learnt}");
        let info = done(&["info", text(&out), "--json"]);
        let near = |found: &Value, expected: f64| (found.as_f64().unwrap() - expected).abs() < 1e-5;
        assert!((0..2).all(|corner| near(&info["aabb"][corner][0], side[corner])), "{info}");
        assert!(near(&info["world"]["scale"], scale), "{info}");
    }
}

#[test]
fn options_that_volumes_do_not_have() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("none.pnerf");
    let (tensors, voxels) = (format!("{VOLUMES}plain.th"), format!("{VOLUMES}four.npz"));
    for (file, option, means) in [
        (&tensors, &["--scene-scale", "0.5"][..], "this is no grid of svox2"),
        (&tensors, &["--samples", "64,64"], "this is a model of apchenstu/TensoRF"),
        (&voxels, &["--aabb", "0,0,0,1,1,1"], "this is a model of sxyu/svox2"),
        (&voxels, &["--distill-to", "1000"], "no model is that small"),
    ] {
        let line = refused(&[&["convert", file, text(&out), "--quiet"][..], option].concat());
        assert!(line.contains(means) && line.contains(option[0]), "{line}");
        assert!(!out.exists());
    }
}
