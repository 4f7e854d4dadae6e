//! `pocketnerf train --teachers`.

use crate::place::Place;

const TRAIN: &str = "train builtin:room --downscale-factor 16 --json --quiet --log2-hashmap-size 9 \
                     --batch-rays 64 --steps 40 --exposure off";

#[test]
fn a_run_learns_from_teachers_where_it_is_asked_to() {
    let place = Place::new();
    let taught = place.ok(&format!("{TRAIN} --teachers 2 --out m.pnerf --save-every 0.000001"));
    assert_eq!(taught["teachers"], 2);
    place.ok(&format!("{TRAIN} --teachers 2 --out one.pnerf --threads 1"));
    assert!(place.bytes("one.pnerf") == place.bytes("m.pnerf"));
    // A run that goes on has the teachers that it had.
    let resume = "train builtin:room --downscale-factor 16 --json --quiet --resume m.ckpt.pnerf \
                  --out again.pnerf";
    assert_eq!(place.ok(resume)["teachers"], 2);
    assert!(place.bytes("again.pnerf") == place.bytes("m.pnerf"));
    let line = place.line(&format!("{resume} --teachers 1"));
    assert!(line.contains("m.ckpt.pnerf") && line.contains("--teachers 1"), "{line}");
    // A short run of many photographs has none.
    assert_eq!(place.ok(&format!("{TRAIN} --out alone.pnerf"))["teachers"], 0);
    assert!(place.bytes("alone.pnerf") != place.bytes("m.pnerf"));
}

#[test]
fn teachers_are_refused_where_they_cannot_teach() {
    let place = Place::new();
    let refused = |options: &str| {
        let line = place.line(&format!("train {options} --teachers 2 --out m.pnerf --quiet"));
        assert!(line.contains("--teachers: expected"), "{options}: {line}");
        assert!(!place.path("m.pnerf").exists());
    };
    refused("builtin --downscale-factor 16");
    refused("builtin:room --downscale-factor 16 --refine-poses");
    refused("builtin:room --downscale-factor 16 --method nerf");
}
