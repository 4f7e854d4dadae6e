//! `pocketnerf train` with photographs that are brighter or darker than each other.

use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{self, Split};

use crate::place::Place;

const TRAIN: &str = "train uneven --json --quiet --log2-hashmap-size 9 --batch-rays 64 --steps 40";

/// The still life, every other photograph darker by a quarter.
fn uneven() -> Place {
    let place = Place::new();
    let mut photos = builtin::dataset(Split::Train, 8);
    for view in photos.views.iter_mut().step_by(2) {
        for pixel in view.rgba.chunks_exact_mut(4) {
            pixel[..3].iter_mut().for_each(|value| *value -= *value / 4);
        }
    }
    std::fs::create_dir(place.path("uneven")).unwrap();
    dataset::write(&place.path("uneven"), Split::Train, &photos.views).unwrap();
    place
}

#[test]
fn photographs_are_evened_out_unless_that_is_off() {
    let place = uneven();
    let result = place.ok(&format!("{TRAIN} --out whole.pnerf --save-every 0.000001"));
    assert_eq!(result["exposure_evened_out"], true);
    // A run that goes on evens out as the one before.
    let resume = "train uneven --json --quiet --resume whole.ckpt.pnerf --out again.pnerf";
    let again = place.ok(resume);
    assert_eq!(again["exposure_evened_out"], true);
    assert!(place.bytes("again.pnerf") == place.bytes("whole.pnerf"));
    let line = place.line(&format!("{resume} --exposure off"));
    assert!(line.contains("whole.ckpt.pnerf") && line.contains("--exposure off"), "{line}");

    let result = place.ok(&format!("{TRAIN} --out off.pnerf --exposure off"));
    assert_eq!(result["exposure_evened_out"], false);
    assert!(place.bytes("off.pnerf") != place.bytes("whole.pnerf"));
    let result = place.ok(&TRAIN.replace("uneven", "builtin --downscale-factor 8 --out x.pnerf"));
    assert_eq!(result["exposure_evened_out"], false);
}
