//! `train --method plenoxels`: every command takes its model.

use crate::place::Place;

const TRAIN: &str = "train data --json --quiet --exposure off --batch-rays 256 --method plenoxels";

#[test]
fn every_command_takes_voxels() {
    let place = Place::new();
    let trained = place.ok(&format!("{TRAIN} --voxels 64 --steps 200 --out m.pnerf"));
    assert_eq!((&trained["method"], &trained["steps"]), (&"plenoxels".into(), &200.into()));
    let info = place.ok("info m.pnerf --json");
    assert_eq!((&info["method"], &info["precision"]), (&"plenoxels".into(), &"i8".into()));
    assert!(info["parameters"].as_u64().unwrap() > 64 * 16);
    let eval = place.ok("eval m.pnerf data --split train --json");
    assert_eq!(eval["method"], "plenoxels");
    assert!(eval["psnr"].as_f64().unwrap() > 15.0, "{eval}");
    place.ok("render m.pnerf --width 24 --height 20 --depth --normals --out m.png");
    place.ok("unpack m.pnerf plain.pnerf");
    place.ok("render plain.pnerf --width 24 --height 20 --out plain.png");
    assert!(place.bytes("m.png") == place.bytes("plain.png"));
    place.ok("export m.pnerf --points m.ply");
}

#[test]
fn a_run_is_interrupted_and_goes_on() {
    let place = Place::new();
    let train = format!("{TRAIN} --voxels 256 --sh-bands 1 --steps 30 --save-every 0.000001");
    place.ok(&format!("{train} --out a.pnerf"));
    place.ok("train data --resume a.ckpt.pnerf --out b.pnerf");
    assert!(place.bytes("a.pnerf") == place.bytes("b.pnerf"));
}

#[test]
fn options_of_other_kinds_are_refused() {
    let place = Place::new();
    let line = |options: &str| place.line(&format!("train data --quiet --out m.pnerf {options}"));
    let voxels = |options: &str| line(&format!("--method plenoxels {options}"));
    assert_eq!(line("--voxels 128"), "--voxels: give --method plenoxels too");
    assert_eq!(line("--sh-bands 2"), "--sh-bands: give --method plenoxels too");
    assert_eq!(voxels("--n-levels 8"), "--n-levels: for --method hash-grid alone");
    assert_eq!(voxels("--profile fast"), "--profile fast: for --method hash-grid alone");
    assert_eq!(voxels("--max-bytes 100000"), "--max-bytes: for --method hash-grid alone");
    let refine = voxels("--refine-poses");
    assert_eq!(refine, "--refine-poses: for --method hash-grid alone");
    for options in ["--voxels 130", "--voxels 1024", "--sh-bands 4"] {
        let output = place.run(&format!("train data --out m.pnerf --method plenoxels {options}"));
        assert_eq!(output.status.code(), Some(2), "{options}");
    }
    assert!(!place.path("m.pnerf").exists());
}
