//! Kinds of field beside the hash grid.

mod baselines;
mod derf;
mod planes;
mod plenoxels;

use serde_json::Value;

use crate::place::Place;

/// Trains 200 steps by these options; then every command takes the model. Gives what `info` says
/// of it.
fn taken_by_every_command(method: &str, options: &str) -> Value {
    let place = Place::new();
    let train = format!("{} --steps 200 --out m.pnerf", train(method, options));
    let trained = place.ok(&train);
    assert_eq!((&trained["method"], &trained["steps"]), (&method.into(), &200.into()));
    let info = place.ok("info m.pnerf --json");
    assert_eq!(info["method"], method);
    let eval = place.ok("eval m.pnerf data --split train --json");
    assert_eq!(eval["method"], method);
    assert!(eval["psnr"].as_f64().unwrap() > 15.0, "{eval}");
    place.ok("render m.pnerf --width 24 --height 20 --depth --normals --out m.png");
    place.ok("unpack m.pnerf plain.pnerf");
    place.ok("render plain.pnerf --width 24 --height 20 --out plain.png");
    assert!(place.bytes("m.png") == place.bytes("plain.png"));
    place.ok("export m.pnerf --points m.ply");
    info
}

/// A run of 30 steps by these options goes on from a checkpoint as if nothing had happened.
fn goes_on_after_an_interruption(method: &str, options: &str) {
    let place = Place::new();
    let train = train(method, options);
    place.ok(&format!("{train} --steps 30 --save-every 0.000001 --out a.pnerf"));
    place.ok("train data --resume a.ckpt.pnerf --out b.pnerf");
    assert!(place.bytes("a.pnerf") == place.bytes("b.pnerf"));
}

/// Each line of options is refused with the text beside it, and those without one by `--help`'s
/// words; no model is written.
fn refused(method: &str, lines: &[(&str, &str)], out_of_range: &[&str]) {
    let place = Place::new();
    for (options, expected) in lines {
        let line = place.line(&format!("train data --quiet --out m.pnerf {options}"));
        assert_eq!(line, *expected, "{options}");
    }
    for options in out_of_range {
        let output = place.run(&format!("train data --out m.pnerf --method {method} {options}"));
        assert_eq!(output.status.code(), Some(2), "{options}");
    }
    assert!(!place.path("m.pnerf").exists());
}

fn train(method: &str, options: &str) -> String {
    format!("train data --json --quiet --exposure off --batch-rays 256 --method {method} {options}")
}
