//! `train --method llff`, `srn` and `neural-volumes`: files of their own.

use super::refused;
use crate::place::{Place, text};

const METHODS: [&str; 3] = ["llff", "srn", "neural-volumes"];

#[test]
fn what_is_trained_is_compared_rendered_and_shown() {
    let place = Place::new();
    for method in METHODS {
        let train = "train data --json --quiet --steps 20 --seed 5 --background white";
        let trained = place.ok(&format!("{train} --method {method} --out m.pnbase"));
        assert_eq!((&trained["method"], &trained["steps"]), (&method.into(), &20.into()));
        assert_eq!((&trained["device"], &trained["seed"]), (&"cpu".into(), &5.into()));
        let bytes = place.bytes("m.pnbase").len();
        assert_eq!(trained["bytes"], bytes);
        let info = place.ok("info m.pnbase --json");
        assert_eq!((&info["method"], &info["bytes"]), (&method.into(), &bytes.into()));
        assert!(info["parameters"].as_u64().unwrap() > 1000, "{info}");
        let shown = text(&place.run("info m.pnbase").stdout);
        assert!(shown.contains(method) && shown.contains("20 steps, seed 5"), "{shown}");
        let eval = place.ok("eval m.pnbase data --split train --out compared --json");
        assert_eq!((&eval["method"], &eval["lpips"]), (&method.into(), &serde_json::Value::Null));
        assert!(eval["psnr"].as_f64().unwrap() > 5.0, "{eval}");
        assert!(place.path("compared/worst-1.png").is_file());
        let orbit = "render m.pnbase --orbit 3 --width 24 --height 20 --json --out";
        let rendered = place.ok(&format!("{orbit} orbit-{method}"));
        assert_eq!((&rendered["pictures"], &rendered["width"]), (&3.into(), &24.into()));
        let pictures = std::fs::read_dir(place.path(&format!("orbit-{method}"))).unwrap();
        assert_eq!(pictures.count(), 3);
        // A model is needed.
        for command in ["export m.pnbase --points m.ply", "unpack m.pnbase plain.pnerf"] {
            let line = place.line(command);
            assert!(line.contains("this is a baseline, expected a model"), "{line}");
        }
        let line = place.line("render m.pnbase --depth --out m.png");
        assert_eq!(line, "--depth: for models alone, and this is a baseline");
    }
}

#[test]
fn a_run_is_interrupted_and_goes_on() {
    let place = Place::new();
    for method in METHODS {
        let train = format!("train data --json --quiet --method {method} --steps 4");
        place.ok(&format!("{train} --save-every 0.000001 --out a.pnbase"));
        let info = place.ok("info a.ckpt.pnerf --json");
        assert_eq!((&info["method"], &info["checkpoint"]["step"]), (&method.into(), &4.into()));
        place.ok("train data --json --quiet --resume a.ckpt.pnerf --out b.pnbase");
        assert!(place.bytes("a.pnbase") == place.bytes("b.pnbase"), "{method}");
        let line = place.line("train data --quiet --resume a.ckpt.pnerf --seed 2 --out c.pnbase");
        assert_eq!(line, "--seed: the checkpoint knows; leave it out");
        let line = place.line("eval a.ckpt.pnerf data");
        assert!(line.ends_with("this is a checkpoint of a run, expected a finished baseline"));
    }
}

#[test]
fn options_of_fields_are_refused() {
    let lines = [
        ("--method srn --batch-rays 64", "--batch-rays: baselines have no such option"),
        ("--method srn --precision f16", "--precision: baselines have no such option"),
        ("--method srn --space box", "--space: baselines have no such option"),
        ("--method llff --refine-poses", "--refine-poses: baselines have no such option"),
        (
            "--method llff --no-view-dependence",
            "--no-view-dependence: baselines have no such option",
        ),
        ("--method neural-volumes --heads 4", "--heads: give --method derf too"),
        ("--method neural-volumes --n-levels 8", "--n-levels: for --method hash-grid alone"),
        ("--method srn --max-bytes 100000", "--max-bytes: for --method hash-grid and planes alone"),
    ];
    refused("srn", &lines, &["--steps 0"]);
}

#[test]
fn what_a_method_cannot_learn_from_is_refused_by_name() {
    let place = Place::new();
    // Something else at every edge: what is behind the scene is not known.
    for i in 0..12_u32 {
        let pixels: Vec<u8> = (0..3 * 25 * 25).map(|k| (k * (i + 7) % 251) as u8).collect();
        let file = place.path("data").join(format!("{i}.png"));
        image::save_buffer(file, &pixels, 25, 25, image::ColorType::Rgb8).unwrap();
    }
    let line = place.line("train data --quiet --method neural-volumes --steps 2 --out m.pnbase");
    let expected = "data: the background of these photographs is not known, expected images with";
    assert!(line.starts_with(expected), "{line}");
    let line = place.line("train data --quiet --method llff --views 1 --steps 2 --out m.pnbase");
    assert_eq!(line, "data: 1 photographs, expected at least 2 for this method");
    assert!(!place.path("m.pnbase").exists());
}

#[test]
fn they_stand_in_one_chart_with_models() {
    let place = Place::new();
    let chart =
        "chart data --split val --views 2 --rounds 1 --qualities 0,1 --json --quiet --out c";
    let of = |options: &str| format!("--train=--steps 10 --method {options}");
    let recipes = [of("srn"), of("neural-volumes"), of("nerf --depth 2 --width 16")];
    let mut command = place.command(chart);
    // Its own training views stand for those that are held out.
    for split in ["val", "test"] {
        let frames = place.path("data").join("transforms_train.json");
        let copy = place.path("data").join(format!("transforms_{split}.json"));
        std::fs::copy(frames, copy).unwrap();
    }
    let output = command.args(&recipes).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let points: serde_json::Value = serde_json::from_slice(&place.bytes("c/points.json")).unwrap();
    let points = points["points"].as_array().unwrap();
    let methods: Vec<&str> = points.iter().map(|p| p["method"].as_str().unwrap()).collect();
    // A baseline has one way, a model two.
    assert_eq!(methods, ["srn", "neural-volumes", "nerf", "nerf"]);
    for point in points {
        for known in ["psnr", "psnr_min", "ssim", "ms_per_frame", "train_seconds", "bytes"] {
            assert!(point[known].as_f64().unwrap().is_finite(), "{known}: {point}");
        }
        let picture = format!("c/pictures/{}.png", point["id"].as_str().unwrap());
        assert!(place.path(&picture).is_file(), "{picture}");
    }
    assert_eq!(points[0]["quality"], serde_json::Value::Null);
    let again = points[0]["eval_command"].as_str().unwrap();
    assert!(!again.contains("--quality") && again.starts_with("pocketnerf eval"), "{again}");
}

#[test]
fn what_spoils_them_is_measured_too() {
    let place = Place::new();
    let stress = "stress --out s --quick --steps 8 --downscale-factor 20 --quiet --json \
                  --methods srn --modes views,learning-rate,test-background,skipping";
    let rows = place.ok(stress)["rows"].clone();
    let rows = rows.as_array().unwrap();
    assert!(rows.len() >= 2 && rows.iter().all(|row| row["method"] == "srn"), "{rows:?}");
    assert!(rows.iter().any(|row| row["psnr"].as_f64().is_some()), "{rows:?}");
}
