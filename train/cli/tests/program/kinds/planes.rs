//! `train --method planes`: every command takes its model.

use crate::place::Place;

const TRAIN: &str = "train data --json --quiet --exposure off --batch-rays 256 --method planes";

#[test]
fn every_command_takes_planes() {
    let place = Place::new();
    let trained = place.ok(&format!("{TRAIN} --plane-resolution 64 --steps 200 --out m.pnerf"));
    assert_eq!((&trained["method"], &trained["steps"]), (&"planes".into(), &200.into()));
    let info = place.ok("info m.pnerf --json");
    assert_eq!(
        (&info["method"], &info["precision"]),
        (&"planes".into(), &"i8 tables, f16 networks".into())
    );
    // Six planes and six lines of eight values an entry, and networks.
    let tables = 6 * 8 * (64 * 64 + 64);
    let parameters = info["parameters"].as_u64().unwrap();
    assert!((tables..tables + 20_000).contains(&parameters), "{parameters}");
    let eval = place.ok("eval m.pnerf data --split train --json");
    assert_eq!(eval["method"], "planes");
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
    let train = format!("{TRAIN} --plane-resolution 128 --components 32 --steps 30");
    place.ok(&format!("{train} --save-every 0.000001 --out a.pnerf"));
    place.ok("train data --resume a.ckpt.pnerf --out b.pnerf");
    assert!(place.bytes("a.pnerf") == place.bytes("b.pnerf"));
}

#[test]
fn options_of_other_kinds_are_refused() {
    let place = Place::new();
    let line = |options: &str| place.line(&format!("train data --quiet --out m.pnerf {options}"));
    let planes = |options: &str| line(&format!("--method planes {options}"));
    let without = "--plane-resolution: give --method planes too";
    assert_eq!(line("--plane-resolution 128"), without);
    assert_eq!(line("--components 16"), "--components: give --method planes too");
    assert_eq!(planes("--n-levels 8"), "--n-levels: for --method hash-grid alone");
    assert_eq!(planes("--voxels 64"), "--voxels: give --method plenoxels too");
    assert_eq!(planes("--max-bytes 100000"), "--max-bytes: for --method hash-grid alone");
    let refine = planes("--refine-poses");
    assert_eq!(refine, "--refine-poses: for --method hash-grid alone");
    for options in ["--plane-resolution 8", "--plane-resolution 2000", "--components 24"] {
        let output = place.run(&format!("train data --out m.pnerf --method planes {options}"));
        assert_eq!(output.status.code(), Some(2), "{options}");
    }
    assert!(!place.path("m.pnerf").exists());
}
