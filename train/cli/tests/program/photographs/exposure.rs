//! `pocketnerf train` with photographs that are brighter or darker than each other.

use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{self, Split, View};
use serde_json::Value;

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
    place.ok(&format!("{TRAIN} --out one.pnerf --threads 1"));
    assert!(place.bytes("one.pnerf") == place.bytes("whole.pnerf"));
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
    let result = place.ok(&TRAIN.replace("uneven", "builtin --downscale-factor 16 --out x.pnerf"));
    assert_eq!(result["exposure_evened_out"], false);
}

/// Test photographs that differ from the training ones are compared apart from that.
#[test]
fn exposure_is_fitted_on_left_halves() {
    let place = Place::new();
    let photos = builtin::dataset(Split::Test, 4);
    let write = |folder: &str, views: &[View]| {
        std::fs::create_dir(place.path(folder)).unwrap();
        dataset::write(&place.path(folder), Split::Test, views).unwrap();
    };
    write("even", &photos.views);
    let mut uneven = photos.views.clone();
    for (i, view) in uneven.iter_mut().enumerate() {
        let gains = if i % 2 == 0 { [0.6, 0.7, 0.8] } else { [0.9, 0.8, 0.5] };
        for pixel in view.rgba.chunks_exact_mut(4) {
            for (value, gain) in pixel.iter_mut().zip(gains) {
                *value = (f32::from(*value) * gain).round() as u8;
            }
        }
    }
    write("uneven", &uneven);
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../../embed-demo/still-life.pnerf");
    let eval = |data: &str, more: &str| place.ok(&format!("eval {model} {data} --json {more}"));
    let psnr = |result: &Value| result["psnr"].as_f64().unwrap();
    let (plain, even) = (eval("uneven", ""), eval("even", "--fit-exposure"));
    let fitted = eval("uneven", "--fit-exposure");
    assert!(psnr(&plain) < psnr(&even) - 6.0, "{} {}", psnr(&plain), psnr(&even));
    // Photographs that are darker have smaller errors.
    assert!(
        (0.0..5.0).contains(&(psnr(&fitted) - psnr(&even))),
        "{} {}",
        psnr(&fitted),
        psnr(&even)
    );
    assert_eq!((&plain["fit_exposure"], &fitted["fit_exposure"]), (&false.into(), &true.into()));
    assert!(plain["per_view"][0]["exposure"].is_null());
    for (view, gains) in [(0, [0.6, 0.7, 0.8]), (1, [0.9, 0.8, 0.5])] {
        for (c, gain) in gains.into_iter().enumerate() {
            let found = fitted["per_view"][view]["exposure"][c].as_f64().unwrap();
            let own = even["per_view"][view]["exposure"][c].as_f64().unwrap();
            assert!((found / own / gain - 1.0).abs() < 0.03, "{view}, {c}: {found} {own}");
        }
    }
}
