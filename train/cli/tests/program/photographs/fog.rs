//! `pocketnerf train --fog`.

use crate::place::Place;

const TRAIN: &str = "train builtin:room --downscale-factor 16 --json --quiet --log2-hashmap-size 9 \
                     --batch-rays 512 --exposure off";

#[test]
fn a_place_loses_its_fog_unless_it_is_to_stay() {
    let place = Place::new();
    let long = format!("{TRAIN} --steps 1400");
    let cleared = place.ok(&format!("{long} --out m.pnerf"));
    assert_eq!(cleared["fog_cleared"], true);
    assert_eq!(place.ok(&format!("{long} --fog keep --out kept.pnerf"))["fog_cleared"], false);
    assert!(place.bytes("m.pnerf") != place.bytes("kept.pnerf"));
    place.ok(&format!("{long} --fog clear --out asked.pnerf"));
    assert!(place.bytes("m.pnerf") == place.bytes("asked.pnerf"));
}

#[test]
fn fog_is_refused_where_it_means_nothing() {
    let place = Place::new();
    let line = place.line("train builtin:room --method nerf --fog clear --out m.pnerf --quiet");
    assert!(line.ends_with("--fog clear: expected --method hash-grid or planes"), "{line}");
    // A run that goes on does what it did.
    place.ok(&format!("{TRAIN} --steps 20 --out m.pnerf --save-every 0.000001"));
    let resume = "train builtin:room --downscale-factor 16 --json --quiet --resume m.ckpt.pnerf \
                  --out again.pnerf";
    let line = place.line(&format!("{resume} --fog keep"));
    assert!(line.contains("m.ckpt.pnerf") && line.contains("--fog keep"), "{line}");
    place.ok(&format!("{resume} --fog clear"));
    assert!(place.bytes("again.pnerf") == place.bytes("m.pnerf"));
}
