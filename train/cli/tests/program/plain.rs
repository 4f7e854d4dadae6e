//! `pocketnerf train` with opaque photographs before a plain background.

use crate::place::{Place, TRAIN, text};
use pocketnerf_train::picture::image_file;

/// Those of the built-in scene, on white.
fn on_white() -> Place {
    let place = Place::new();
    for i in 0..12 {
        let file = place.path(&format!("data/{i}.png"));
        let mut photo = image_file::open(&file).unwrap().to_rgba8();
        for pixel in photo.pixels_mut() {
            let alpha = f32::from(pixel.0[3]) / 255.0;
            let over = |value: u8| (f32::from(value) * alpha + 255.0 * (1.0 - alpha)).round() as u8;
            pixel.0 = [over(pixel.0[0]), over(pixel.0[1]), over(pixel.0[2]), 255];
        }
        photo.save(&file).unwrap();
    }
    place
}

#[test]
fn a_plain_background_is_cut_out_unless_another_is_given() {
    let place = on_white();
    let train = TRAIN.replace("--quiet ", "");
    for (options, is_cut_out) in
        [("", true), ("--background white", true), ("--background black", false)]
    {
        let command = format!("{train} --steps 20 --out x.pnerf {options}");
        let output = place.run(&command);
        let said = text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert_eq!(said.contains("is plain and is cut out"), is_cut_out, "{options}: {said}");
        let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(result["background_cut_out"], is_cut_out, "{options}");
    }
    // What has alpha is left alone.
    let result = Place::new().ok(&format!("{TRAIN} --steps 20 --out x.pnerf"));
    assert_eq!(result["background_cut_out"], false);
}

/// The run that goes on cuts out as the one before.
#[test]
fn a_run_before_a_plain_background_is_resumed() {
    let place = on_white();
    for options in ["", "--background white"] {
        let train = format!("{TRAIN} --steps 40 {options}");
        place.ok(&format!("{train} --out whole.pnerf --save-every 0.000001"));
        let again = place.ok("train data --json --resume whole.ckpt.pnerf --out again.pnerf");
        assert_eq!(again["background_cut_out"], true, "{options}");
        assert!(place.bytes("again.pnerf") == place.bytes("whole.pnerf"), "{options}");
    }
}
