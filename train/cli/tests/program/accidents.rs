//! `pocketnerf train`: what may go wrong, and what is said of it.

#[cfg(unix)]
use std::io::{BufRead, BufReader, Read as _};
#[cfg(unix)]
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::place::{Place, TRAIN};

/// Cuts the end off a file.
fn cut(file: &std::path::Path) {
    let bytes = std::fs::read(file).unwrap();
    std::fs::write(file, &bytes[..bytes.len() - 20]).unwrap();
}

#[test]
fn no_time_for_a_step_is_an_error() {
    let place = Place::new();
    std::fs::write(place.path("x.pnerf"), "old").unwrap();
    // Over before the first image, and before the first step.
    for seconds in ["0.000001", "0.05"] {
        let line = place.line(&format!("train data --quiet --out x.pnerf --seconds {seconds}"));
        let expected =
            format!("--seconds {seconds}: reading the images and finding the scene takes ");
        assert!(line.starts_with(&expected), "{line}");
        assert!(line.contains(" s, which leaves no time to train; expected at least "), "{line}");
    }
    assert_eq!(place.bytes("x.pnerf"), b"old");
}

#[test]
fn too_few_steps_are_said() {
    let place = Place::new();
    let warnings = |kind: &str, steps: u32| {
        let train = TRAIN.replace("--log2-hashmap-size 9", kind);
        let train = format!("{train} --steps {steps}");
        let result = place.ok(&format!("{train} --out x.pnerf"));
        result["warnings"].as_array().unwrap().clone()
    };
    for (kind, enough) in [("--log2-hashmap-size 9", 512), ("--plane-resolution 32", 1024)] {
        for few in [3, enough / 2 + 3] {
            let [warning] = &warnings(kind, few)[..] else { panic!("one warning") };
            let expected =
                format!("only {few} steps were taken, expected at least {enough}; train longer");
            assert_eq!(warning, &expected);
        }
        assert_eq!(warnings(kind, enough), [Value::Null; 0]);
    }
}

#[test]
fn a_bad_photograph_is_left_out_and_many_are_refused() {
    let place = Place::new();
    cut(&place.path("data/3.png"));
    let report = place.ok("info data --json");
    assert_eq!(report["splits"][0]["images_unreadable"], serde_json::json!(["3"]));
    let result = place.ok(&format!("{TRAIN} --steps 5 --out x.pnerf"));
    let warning = result["warnings"][0].as_str().unwrap();
    assert_eq!(
        warning,
        "data/3.png: unreadable image: the file is cut off: its end is missing; expected a whole \
         PNG, JPEG, WebP, TIFF or EXR file; 1 of 12 images are left out"
    );
    cut(&place.path("data/7.png"));
    let line = place.line("train data --quiet --steps 5 --out x.pnerf");
    assert!(line.starts_with("data/3.png: unreadable image: "), "{line}");
}

#[test]
fn scores_of_another_scene_are_said() {
    let place = Place::new();
    place.ok(&format!("{TRAIN} --steps 5 --out x.pnerf"));
    let eval = |data: &str| {
        let result = place.ok(&format!("eval x.pnerf {data} --json"));
        result["warnings"].as_array().unwrap().clone()
    };
    assert_eq!(eval("data --split train"), [Value::Null; 0]);
    // The same under another name.
    std::fs::rename(place.path("data"), place.path("renamed")).unwrap();
    assert_eq!(eval("renamed --split train"), [Value::Null; 0]);
    // Another scene in a folder of that name: its cameras are elsewhere.
    std::fs::create_dir(place.path("data")).unwrap();
    for entry in std::fs::read_dir(place.path("renamed")).unwrap() {
        let from = entry.unwrap().path();
        std::fs::copy(&from, place.path("data").join(from.file_name().unwrap())).unwrap();
    }
    assert_eq!(eval("data --split train"), [Value::Null; 0]);
    let cameras = place.path("data/transforms_train.json");
    let text = std::fs::read_to_string(&cameras).unwrap();
    let mut moved: Value = serde_json::from_str(&text).unwrap();
    for frame in moved["frames"].as_array_mut().unwrap() {
        let x = &mut frame["transform_matrix"][0][3];
        *x = (x.as_f64().unwrap() + 0.25).into();
    }
    std::fs::write(&cameras, moved.to_string()).unwrap();
    let [warning] = &eval("data --split train")[..] else { panic!("one warning") };
    assert!(
        warning
            .as_str()
            .unwrap()
            .starts_with("x.pnerf: trained on \"data\", expected a model of data")
    );
    let [warning] = &eval("builtin --downscale-factor 16")[..] else { panic!("one warning") };
    assert_eq!(
        warning,
        "x.pnerf: trained on \"data\", expected a model of builtin: the scores may be those of \
         another scene"
    );
}

#[test]
fn built_in_scenes_are_told_apart() {
    let place = Place::new();
    let train = "train builtin:wires --downscale-factor 16 --log2-hashmap-size 9 --batch-rays 64";
    place.ok(&format!("{train} --json --quiet --steps 5 --out x.pnerf"));
    let warnings = |data: &str| {
        let result = place.ok(&format!("eval x.pnerf {data} --downscale-factor 16 --json"));
        result["warnings"].as_array().unwrap().clone()
    };
    assert_eq!(warnings("builtin:wires"), [Value::Null; 0]);
    assert_eq!(
        warnings("builtin:white"),
        ["x.pnerf: trained on \"built-in scene wires\", expected a model of builtin:white: the \
          scores may be those of another scene"]
    );
    let line = place.line("eval x.pnerf builtin:wire");
    assert_eq!(
        line,
        "builtin:wire: no such built-in scene; expected one of builtin:still-life, \
         builtin:wires, builtin:glossy, builtin:glass, builtin:foliage, builtin:fog, \
         builtin:white, builtin:room, builtin:village"
    );
}

/// Reading the built-in scene at its full size takes seconds.
#[cfg(unix)]
#[test]
fn before_the_first_step_a_signal_ends_the_program() {
    let place = Place::new();
    for signal in ["-INT", "-TERM", "-HUP"] {
        let mut command = place.command("train builtin --out x.pnerf");
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        assert_eq!(line, "reading the images\n");
        let pid = child.id().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}");
        let mut rest = String::new();
        said.read_to_string(&mut rest).unwrap();
        let expected = "pocketnerf: interrupted before the first step; there is nothing to save\n";
        assert_eq!(rest, expected);
    }
    assert_eq!(std::fs::read_dir(place.0.path()).unwrap().count(), 1);
}

/// Says in a PNG file that it has so many pixels a side.
fn grow(file: &std::path::Path, side: u32) {
    let mut bytes = std::fs::read(file).unwrap();
    bytes[16..20].copy_from_slice(&side.to_be_bytes());
    bytes[20..24].copy_from_slice(&side.to_be_bytes());
    // The checksum of the name and what follows it.
    let checksum = !bytes[12..29].iter().fold(u32::MAX, |sum, byte| {
        let bit = |sum: u32| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg());
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| bit(sum))
    });
    bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
    std::fs::write(file, bytes).unwrap();
}

#[test]
fn images_that_do_not_fit_into_memory_are_refused_before_they_are_decoded() {
    let place = Place::new();
    // 12 images of 900,000 x 900,000 pixels: 39 TB, and two of them decoded.
    for i in 0..12 {
        grow(&place.path(&format!("data/{i}.png")), 900_000);
    }
    let line = place.line("train data --quiet --steps 5 --out x.pnerf");
    let expected = "data: 12 images of up to 900000x900000 pixels need ";
    assert!(line.starts_with(expected) && line.contains(" GB are free; give "), "{line}");
}

/// Scripts find what they should know in one place.
#[test]
fn each_object_has_warnings() {
    let place = Place::new();
    place.ok(&format!("{TRAIN} --steps 3 --out x.pnerf"));
    for command in [
        "info data",
        "info x.pnerf",
        "render x.pnerf --width 24 --height 24",
        "eval x.pnerf data --split train",
        "convert x.pnerf y.pnerf",
    ] {
        let object = place.ok(&format!("{command} --json"));
        assert_eq!(object["warnings"], serde_json::json!([]), "{command}: {object}");
    }
    let small = "render x.pnerf --width 8 --height 6 --orbit 2 --out views";
    let rendered = place.ok(&format!("{small} --antialias off --json"));
    let [pictures, width, height] = ["pictures", "width", "height"].map(|key| &rendered[key]);
    assert_eq!((pictures, width, height), (&2.into(), &8.into(), &6.into()));
    assert!(rendered["seconds_per_frame"].as_f64().unwrap() > 0.0);
    // Small pictures of one ray a pixel are jagged.
    assert!(rendered["warnings"][0].as_str().unwrap().contains("times as much in a pixel"));
    // What is wrong with a dataset is a warning too.
    cut(&place.path("data/3.png"));
    let object = place.ok("info data --json");
    let line = "images that are unreadable or cut off: 1 of 12 (first: 3); copy them again";
    assert_eq!(object["warnings"], serde_json::json!([line]));
    assert_eq!(object["suspicions"], serde_json::json!([{"kind": "unreadable", "text": line}]));
}

#[test]
fn that_an_older_file_was_replaced_is_said() {
    let place = Place::new();
    let train = format!("{TRAIN} --steps 3 --out x.pnerf");
    let replaced = [(); 2].map(|()| place.ok(&train)["replaced"].clone());
    assert_eq!(replaced, [false, true]);
    let said = place.run(&train.replace("--json ", ""));
    let said = String::from_utf8(said.stdout).unwrap();
    assert!(said.trim_end().ends_with(" s; an older file was replaced"), "{said}");
}
