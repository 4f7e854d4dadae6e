//! `train --method derf`: every command takes its model.

use crate::place::Place;

const TRAIN: &str = "train data --json --quiet --exposure off --batch-rays 256 --method derf \
                     --width 16 --depth 2";

#[test]
fn every_command_takes_heads() {
    let place = Place::new();
    let trained = place.ok(&format!("{TRAIN} --heads 3 --steps 200 --out m.pnerf"));
    assert_eq!((&trained["method"], &trained["steps"]), (&"derf".into(), &200.into()));
    let info = place.ok("info m.pnerf --json");
    assert_eq!(info["method"], "derf");
    // Layers of 63, 16, 1; 16 + 27, 8, 3 values, and the feature; three sites.
    let head = 64 * 16 + 17 * 16 + 17 + 17 * 16 + 44 * 8 + 9 * 3;
    assert_eq!(info["parameters"].as_u64().unwrap(), 3 * head + 9);
    let eval = place.ok("eval m.pnerf data --split train --json");
    assert_eq!(eval["method"], "derf");
    assert!(eval["psnr"].as_f64().unwrap() > 14.0, "{eval}");
    place.ok("render m.pnerf --width 24 --height 20 --depth --normals --out m.png");
    place.ok("unpack m.pnerf plain.pnerf");
    place.ok("render plain.pnerf --width 24 --height 20 --out plain.png");
    assert!(place.bytes("m.png") == place.bytes("plain.png"));
    place.ok("export m.pnerf --points m.ply");
}

#[test]
fn a_run_is_interrupted_and_goes_on() {
    let place = Place::new();
    let train = format!("{TRAIN} --heads 2 --steps 30 --save-every 0.000001");
    place.ok(&format!("{train} --out a.pnerf"));
    place.ok("train data --resume a.ckpt.pnerf --out b.pnerf");
    assert!(place.bytes("a.pnerf") == place.bytes("b.pnerf"));
}

#[test]
fn options_of_other_kinds_are_refused() {
    let place = Place::new();
    let line = |options: &str| place.line(&format!("train data --quiet --out m.pnerf {options}"));
    let derf = |options: &str| line(&format!("--method derf {options}"));
    assert_eq!(line("--heads 4"), "--heads: give --method derf too");
    assert_eq!(derf("--voxels 64"), "--voxels: give --method plenoxels too");
    assert_eq!(derf("--n-levels 8"), "--n-levels: for --method hash-grid alone");
    assert_eq!(derf("--sampling hierarchical"), "--sampling: for --method nerf alone");
    assert_eq!(derf("--gaussian 16,2"), "--gaussian: for --method nerf alone");
    for options in ["--heads 0", "--heads 65"] {
        let output = place.run(&format!("train data --out m.pnerf --method derf {options}"));
        assert_eq!(output.status.code(), Some(2), "{options}");
    }
    assert!(!place.path("m.pnerf").exists());
}
