//! `pocketnerf train --smooth-surfaces`.

use crate::place::{Place, TRAIN};

#[test]
fn surfaces_are_smooth_where_that_is_asked_for() {
    let place = Place::new();
    let degrees = |name: &str, options: &str| {
        let train = "train builtin:white --downscale-factor 4 --exposure off --profile fast \
                     --steps 400 --json --quiet";
        place.ok(&format!("{train} --out {name}.pnerf {options}"));
        let mesh = format!("export {name}.pnerf --data builtin:white --mesh m.ply");
        let said = place.ok(&format!("{mesh} --resolution 128 --downscale-factor 4 --json"));
        said["surface_error"]["normal_degrees"].as_f64().unwrap()
    };
    let (rough, smooth) = (degrees("rough", ""), degrees("smooth", "--smooth-surfaces=0.02"));
    assert!(smooth < rough - 0.1, "{smooth} {rough}");
}

#[test]
fn a_run_that_goes_on_holds_surfaces_as_before() {
    let place = Place::new();
    let train = format!("{TRAIN} --steps 60");
    place.ok(&format!("{train} --out rough.pnerf"));
    let smooth = "--smooth-surfaces --save-every 1000 --threads 2";
    place.ok(&format!("{train} --out smooth.pnerf {smooth}"));
    assert!(place.bytes("rough.pnerf") != place.bytes("smooth.pnerf"));
    let resume = "train data --resume smooth.ckpt.pnerf --out again.pnerf --quiet";
    place.ok(&format!("{resume} --threads 1 --json"));
    assert!(place.bytes("again.pnerf") == place.bytes("smooth.pnerf"));
    let line = place.line(&format!("{resume} --smooth-surfaces=0.5"));
    assert!(line.contains("--smooth-surfaces 0.005, but --smooth-surfaces 0.5"), "{line}");
}

/// Of places they are smooth by default, of objects not: the same model as with that weight.
#[test]
fn places_are_smooth_by_default() {
    let place = Place::new();
    let model = |dataset: &str, options: &str| {
        let train = "--downscale-factor 8 --exposure off --profile fast --steps 30 --quiet";
        place.ok(&format!("train {dataset} {train} --out m.pnerf {options}"));
        place.bytes("m.pnerf")
    };
    for (dataset, usual, other) in [("builtin:room", "0.02", "0"), ("builtin:white", "0", "0.02")] {
        let weigh = |weight: &str| model(dataset, &format!("--smooth-surfaces={weight}"));
        let by_default = model(dataset, "");
        assert!(by_default == weigh(usual), "{dataset}");
        assert!(by_default != weigh(other), "{dataset}");
    }
}

#[test]
fn what_cannot_be_smooth_is_refused() {
    let place = Place::new();
    for (options, expected) in [
        ("--smooth-surfaces=-0.1", "--smooth-surfaces=-0.1: expected 0 or more"),
        ("--smooth-surfaces=nan", "--smooth-surfaces=NaN: expected 0 or more"),
        (
            "--smooth-surfaces --method nerf --sampling hierarchical",
            "--smooth-surfaces: expected no --sampling hierarchical",
        ),
    ] {
        let line = place.line(&format!("train data --steps 5 --quiet --out x.pnerf {options}"));
        assert!(line.starts_with(expected), "{line}");
    }
}
