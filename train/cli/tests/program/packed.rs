//! Packed files: `train` writes them, every command reads them, `repack` and `unpack` change one
//! into the other.

use pocketnerf_formats::is_packed;
use serde_json::Value;

use crate::place::{Place, TRAIN, text};

#[test]
fn packed_and_unpacked_models_are_the_same() {
    let place = Place::new();
    let trained = place.ok(&format!("{TRAIN} --steps 60 --out packed.pnerf --save-every 0.000001"));
    let packed = place.bytes("packed.pnerf");
    assert_eq!(trained["bytes"], packed.len());
    assert!(is_packed(&packed).unwrap());
    let unpacked = place.ok("unpack packed.pnerf plain.pnerf --json");
    let plain = place.bytes("plain.pnerf");
    assert!(!is_packed(&plain).unwrap() && plain.len() > packed.len());
    assert_eq!(unpacked["bytes_before"], packed.len());
    assert_eq!(unpacked["bytes"], plain.len());
    // There and back.
    place.ok("repack plain.pnerf again.pnerf");
    assert!(place.bytes("again.pnerf") == packed);
    place.ok("repack packed.pnerf again.pnerf");
    assert!(place.bytes("again.pnerf") == packed);
    place.ok("unpack plain.pnerf same.pnerf");
    assert!(place.bytes("same.pnerf") == plain);

    // The same pictures, scores and facts.
    for name in ["packed", "plain"] {
        place.ok(&format!("render {name}.pnerf --width 24 --height 20 --out {name}.png"));
    }
    assert!(place.bytes("packed.png") == place.bytes("plain.png"));
    let of = |command: &str, name: &str| place.ok(&command.replace("MODEL", name));
    let eval = |name: &str| of("eval MODEL data --split train --json --quality 1", name);
    assert_eq!(eval("packed.pnerf")["psnr"], eval("plain.pnerf")["psnr"]);
    assert_eq!(eval("packed.pnerf")["bytes"], packed.len());
    let info = |name: &str| of("info MODEL --json", name);
    let [a, b] = ["packed.pnerf", "plain.pnerf"].map(info);
    assert_eq!((&a["bytes"], &a["unpacked_bytes"]), (&packed.len().into(), &plain.len().into()));
    assert_eq!((&b["bytes"], &b["unpacked_bytes"]), (&plain.len().into(), &plain.len().into()));
    assert_eq!((&a["parameters"], &a["precision"]), (&b["parameters"], &b["precision"]));
    let mut sections = a["sections"].as_array().unwrap().iter();
    let table = sections.find(|s| s["kind"] == "OCC_COARSE").unwrap();
    assert!(table["bytes"].as_u64() < table["unpacked_bytes"].as_u64(), "{table}");

    // A packed checkpoint resumes.
    place.ok("repack packed.ckpt.pnerf small.ckpt.pnerf");
    assert!(place.bytes("small.ckpt.pnerf").len() < place.bytes("packed.ckpt.pnerf").len());
    place.ok("train data --resume small.ckpt.pnerf --out resumed.pnerf");
    assert!(place.bytes("resumed.pnerf") == packed);
}

#[test]
fn damaged_packed_files_are_refused_by_name() {
    let place = Place::new();
    place.ok(&format!("{TRAIN} --steps 5 --out x.pnerf"));
    let mut bytes = place.bytes("x.pnerf");
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(place.path("x.pnerf"), &bytes).unwrap();
    std::fs::write(place.path("old.pnerf"), "old").unwrap();
    for command in ["unpack x.pnerf old.pnerf", "repack x.pnerf old.pnerf", "info x.pnerf"] {
        let line = place.line(command);
        assert!(line.starts_with("x.pnerf: section OCC_FINE: checksum "), "{line}");
    }
    assert_eq!(place.bytes("old.pnerf"), b"old");
    let line = place.line("unpack data/0.png y.pnerf");
    assert!(line.starts_with("data/0.png: "), "{line}");
}

#[test]
fn a_model_in_so_many_bytes() {
    const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../embed-demo/still-life.pnerf");
    let place = Place::new();
    let small = place.ok(&format!("repack {MODEL} small.pnerf --max-bytes 60000 --json"));
    let bytes = place.bytes("small.pnerf").len();
    assert_eq!(small["bytes"], bytes);
    assert!((58_200..=60_000).contains(&bytes), "{small}");
    assert!(small["psnr_to_original"].as_f64().unwrap() > 25.0, "{small}");
    assert!(small["steps"].as_array().unwrap().len() > 4, "{small}");
    place.ok("render small.pnerf --width 24 --height 20");
}

#[test]
fn as_many_bytes_as_asked_for_whether_interrupted_or_not() {
    let place = Place::new();
    // Few parts to try, which are rendered quickly.
    let small = "--log2-hashmap-size 12 --n-levels 4 --hidden-width 16";
    let train = TRAIN.replace("--log2-hashmap-size 9", small);
    let train = format!("{train} --steps 60");
    let whole = place.ok(&format!("{train} --out whole.pnerf"))["bytes"].as_u64().unwrap();
    for most in [whole / 10 * 9, whole / 10 * 7] {
        let result = place.ok(&format!("{train} --max-bytes {most} --out small.pnerf"));
        let bytes = result["bytes"].as_u64().unwrap();
        assert!(bytes < whole && bytes <= most && 100 * bytes >= 97 * most, "{most}: {bytes}");
        assert_eq!(place.bytes("small.pnerf").len() as u64, bytes);
        place.ok("render small.pnerf --width 24 --height 20 --out small.png");
        let again = "--out x.pnerf --save-every 0.000001 --threads 1";
        place.ok(&format!("{train} --max-bytes {most} {again}"));
        assert!(place.bytes("x.pnerf") == place.bytes("small.pnerf"));
    }
    // A run that is over keeps the steps that it has learnt.
    let most = format!("--max-bytes {}", whole / 10 * 7);
    place.ok(&format!("train data --resume x.ckpt.pnerf {most} --out resumed.pnerf"));
    assert!(place.bytes("resumed.pnerf") == place.bytes("small.pnerf"));

    let line = place.line(&format!("{train} --max-bytes 1000 --out x.pnerf"));
    let expected = "--max-bytes 1000: the networks alone take more, expected at least";
    assert!(line.contains(expected), "{line}");

    // Where it is seen at the end that the limit cannot be met, nothing is lost, and the command
    // that is proposed works.
    let most = whole / 5;
    let refused = place.run(&format!("{train} --max-bytes {most} --out tight.pnerf"));
    assert_eq!(refused.status.code(), Some(1));
    let said = text(&refused.stderr);
    // A warning of so few steps comes before.
    let line = said.trim().lines().last().unwrap();
    let (reason, command) = line.split_once("write the model with: pocketnerf ").unwrap();
    assert!(reason.contains(&format!("{most} bytes are too few, expected at least ")), "{line}");
    let least: u64 = command.rsplit_once("--max-bytes ").unwrap().1.trim().parse().unwrap();
    place.ok(command.trim());
    let bytes = place.bytes("tight.pnerf").len() as u64;
    assert!(most < bytes && bytes <= least, "{most} {bytes} {least}");
}

#[test]
fn as_few_bytes_as_the_views_allow_that_were_held_out() {
    let place = Place::new();
    let train = "train builtin --downscale-factor 16 --views 32 --exposure off --steps 320 \
                 --hidden-width 16 --n-levels 6 --log2-hashmap-size 11 --json --quiet";
    let train = |options: &str| place.ok(&format!("{train} {options}"));
    let warned = |result: &Value, text: &str| {
        result["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .any(|line| line.as_str().unwrap().contains(text))
    };
    let held_out = |result: &Value| result["held_out_psnr"].as_f64().unwrap();

    // More than any model has: the best there is, and a line that says so.
    let best = train("--target-psnr 90 --out best.pnerf");
    let psnr = held_out(&best);
    assert!(warned(&best, &format!("not reached, {psnr:.2} dB on held-out views is the best")));

    // One dB less, in fewer bytes, and hardly more than asked for.
    let less = format!("--target-psnr {}", psnr - 1.0);
    let small = train(&format!("{less} --threads 2 --out small.pnerf --save-every 0.000001"));
    let [bytes, whole] = [&small, &best].map(|result| result["bytes"].as_u64().unwrap());
    assert!(10 * bytes < 7 * whole, "{bytes} {whole}");
    assert!((psnr - 1.0..psnr - 0.9).contains(&held_out(&small)), "{psnr} {small}");
    assert!(!warned(&small, "not reached"), "{small}");
    let again = train(&format!("{less} --out again.pnerf --threads 1"));
    assert_eq!(again["size"], small["size"]);
    place.ok(&format!("train builtin --resume small.ckpt.pnerf --views 32 {less} --out re.pnerf"));
    for other in ["again.pnerf", "re.pnerf"] {
        assert!(place.bytes(other) == place.bytes("small.pnerf"), "{other}");
    }

    // Hardly worse than the whole model.
    let auto = train("--auto --out auto.pnerf");
    let whole = train("--out whole.pnerf --save-every 0.000001");
    assert_eq!((&whole["size"], &auto["size"]["asked"]), (&Value::Null, &"--auto".into()));
    assert!(10 * auto["bytes"].as_u64().unwrap() < 9 * whole["bytes"].as_u64().unwrap(), "{auto}");
    let psnr = |model: &str| {
        let eval = format!("eval {model} builtin --downscale-factor 16 --split val --json --quiet");
        place.ok(&eval)["psnr"].as_f64().unwrap()
    };
    let [a, b] = ["auto.pnerf", "whole.pnerf"].map(psnr);
    assert!(a > b - 0.15, "{a} {b}");

    // A run that learnt from all views has none to be measured by.
    let resume = "train builtin --resume whole.ckpt.pnerf --views 32 --out x.pnerf --quiet";
    let line = place.line(&format!("{resume} --target-psnr 20"));
    assert!(line.contains("--target-psnr 20: the run holds no view out any more"), "{line}");
}

#[test]
fn sizes_that_cannot_be_asked_for() {
    let place = Place::new();
    for (option, expected) in [
        ("--target-psnr 30", "--target-psnr 30: no photograph can be held out to measure it"),
        ("--method nerf --auto", "--auto: for --method hash-grid and planes alone"),
        (
            "--method nerf --target-psnr 30",
            "--target-psnr: for --method hash-grid and planes alone",
        ),
    ] {
        let train = TRAIN.replace("--log2-hashmap-size 9", "");
        let line = place.line(&format!("{train} --steps 5 --out x.pnerf {option}"));
        assert!(line.starts_with(expected), "{line}");
    }
    for both in ["--auto --max-bytes 9999", "--auto --target-psnr 30", "--auto --precision f16"] {
        let refused = place.run(&format!("{TRAIN} --steps 5 --out x.pnerf {both}"));
        assert_eq!(refused.status.code(), Some(2), "{both}");
    }
}
