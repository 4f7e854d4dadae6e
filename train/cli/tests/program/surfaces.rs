//! `pocketnerf train --smooth-surfaces`.

use crate::place::Place;

const TRAIN: &str = "train builtin:room --downscale-factor 8 --exposure off --profile fast \
                     --steps 200 --json --quiet";

#[test]
fn surfaces_are_smooth_where_that_is_asked_for() {
    let place = Place::new();
    let degrees = |name: &str, options: &str| {
        place.ok(&format!("{TRAIN} --out {name}.pnerf {options}"));
        let mesh = format!("export {name}.pnerf --data builtin:room --mesh m.ply --resolution 48");
        let said = place.ok(&format!("{mesh} --downscale-factor 8 --json"));
        said["surface_error"]["normal_degrees"].as_f64().unwrap()
    };
    let rough = degrees("rough", "");
    let smooth = degrees("smooth", "--smooth-surfaces --threads 2 --save-every 0.000001");
    assert!(smooth < rough - 2.0, "{smooth} {rough}");
    // The run that goes on holds them as the one before, at any number of threads.
    let resume = "train builtin:room --resume smooth.ckpt.pnerf --out again.pnerf --quiet";
    place.ok(&format!("{resume} --threads 1 --json"));
    assert!(place.bytes("again.pnerf") == place.bytes("smooth.pnerf"));
    let line = place.line(&format!("{resume} --smooth-surfaces=0.5"));
    assert!(line.contains("--smooth-surfaces 0.005, but --smooth-surfaces 0.5"), "{line}");
}

#[test]
fn what_cannot_be_smooth_is_refused() {
    let place = Place::new();
    for (options, expected) in [
        ("--smooth-surfaces=0", "--smooth-surfaces=0: expected more than 0"),
        ("--smooth-surfaces=nan", "--smooth-surfaces=NaN: expected more than 0"),
        (
            "--smooth-surfaces --method nerf --sampling hierarchical",
            "--smooth-surfaces: expected no --sampling hierarchical",
        ),
    ] {
        let line = place.line(&format!("{TRAIN} --out x.pnerf {options}"));
        assert!(line.starts_with(expected), "{line}");
    }
}
