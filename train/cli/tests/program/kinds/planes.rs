//! `train --method planes`.

use super::{goes_on_after_an_interruption, refused, taken_by_every_command, train};
use crate::place::Place;

#[test]
fn every_command_takes_planes() {
    let info = taken_by_every_command("planes", "--plane-resolution 64");
    assert_eq!(info["precision"], "i8 tables, f16 networks");
    // Six planes and six lines of eight values an entry, and networks.
    let tables = 6 * 8 * (64 * 64 + 64);
    let parameters = info["parameters"].as_u64().unwrap();
    assert!((tables..tables + 20_000).contains(&parameters), "{parameters}");
}

#[test]
fn a_run_is_interrupted_and_goes_on() {
    goes_on_after_an_interruption("planes", "--plane-resolution 128 --components 32");
}

/// While training and afterwards, whether interrupted or not.
#[test]
fn a_file_is_as_small_as_asked_for() {
    let place = Place::new();
    let train = train("planes", "--plane-resolution 64 --steps 60");
    let whole = place.ok(&format!("{train} --out whole.pnerf"))["bytes"].as_u64().unwrap();
    let most = whole / 10 * 7;
    let is_near = |bytes: u64| bytes <= most && 100 * bytes >= 97 * most;
    let trained = place.ok(&format!("{train} --max-bytes {most} --out small.pnerf"));
    assert!(is_near(trained["bytes"].as_u64().unwrap()), "{most} {trained}");
    // Twelve tables, some of them rounded.
    let steps = trained["size"]["steps"].as_array().unwrap();
    assert!(steps.len() == 12 && steps.iter().any(|step| *step != 1), "{trained}");
    let again = "--out x.pnerf --save-every 0.000001 --threads 1";
    place.ok(&format!("{train} --max-bytes {most} {again}"));
    assert!(place.bytes("x.pnerf") == place.bytes("small.pnerf"));
    let resumed = format!("train data --resume x.ckpt.pnerf --max-bytes {most} --out re.pnerf");
    place.ok(&resumed);
    assert!(place.bytes("re.pnerf") == place.bytes("small.pnerf"));

    let repacked = place.ok(&format!("repack whole.pnerf r.pnerf --max-bytes {most} --json"));
    assert!(is_near(repacked["bytes"].as_u64().unwrap()), "{most} {repacked}");
    assert!(repacked["psnr_to_original"].as_f64().unwrap() > 25.0, "{repacked}");
    place.ok("render r.pnerf --width 24 --height 20");
    let auto = place.ok(&format!("{train} --auto --out auto.pnerf"));
    assert!(auto["bytes"].as_u64().unwrap() < whole, "{whole} {auto}");

    let line = place.line(&format!("{train} --max-bytes 1000 --out y.pnerf"));
    let expected = "--max-bytes 1000: the networks alone take more, expected at least";
    assert!(line.contains(expected) && !line.contains("--hidden-width"), "{line}");
}

/// Of an object planes, of a place and without an end hash grids, unless options say what they are
/// for.
#[test]
fn a_kind_suits_the_scene() {
    let place = Place::new();
    let method = |options: &str| {
        let train = "train data --json --quiet --exposure off --batch-rays 64 --steps 2";
        place.ok(&format!("{train} --out m.pnerf {options}"))["method"].clone()
    };
    assert_eq!(method("--profile fast"), "planes");
    assert_eq!(method("--space contracted"), "hash-grid");
    assert_eq!(method("--space contracted --plane-resolution 32"), "planes");
    assert_eq!(method("--n-levels 4"), "hash-grid");
    assert_eq!(method("--method hash-grid"), "hash-grid");
    // From within, nothing is transparent.
    let room = "train builtin:room --downscale-factor 8 --json --quiet --exposure off --steps 2";
    assert_eq!(place.ok(&format!("{room} --out m.pnerf"))["method"], "hash-grid");
    let planes = place.ok(&format!("{room} --components 16 --out m.pnerf"));
    assert_eq!(planes["method"], "planes");
}

#[test]
fn a_fast_profile_has_a_narrower_network() {
    let place = Place::new();
    let train = train("planes", "--plane-resolution 32 --steps 40");
    let [fine, fast] = ["fine", "fast"].map(|profile| {
        place.ok(&format!("{train} --profile {profile} --out m.pnerf"));
        place.ok("info m.pnerf --json")["parameters"].as_u64().unwrap()
    });
    // 48 values, 64 or 32, and 16 outputs; colours keep their network.
    let of = |w: u64| 49 * w + (w + 1) * 16;
    assert_eq!(fine - fast, of(64) - of(32));
}

#[test]
fn options_of_other_kinds_are_refused() {
    let lines = [
        ("--method hash-grid --components 16", "--components: give --method planes too"),
        ("--method planes --n-levels 8", "--n-levels: for --method hash-grid alone"),
        ("--components 16 --hidden-width 16", "--hidden-width: for --method hash-grid alone"),
        ("--method planes --voxels 64", "--voxels: give --method plenoxels too"),
    ];
    let out_of_range = ["--plane-resolution 8", "--plane-resolution 2000", "--components 24"];
    refused("planes", &lines, &out_of_range);
}
