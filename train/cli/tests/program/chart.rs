//! `pocketnerf chart`.

use std::path::Path;
use std::process::{Command, Output};

use pocketnerf_train::picture::image_file;
use serde_json::Value;

use super::page::page_works;

/// Two models of a few steps, as thumbnails.
const TINY: [&str; 8] = [
    "--train=--steps 60 --downscale-factor 8 --exposure off --log2-hashmap-size 9 --n-levels 4 --hidden-width 16",
    "--train=--steps 20 --downscale-factor 8 --method nerf --depth 2 --width 16 --batch-rays 64",
    "--downscale-factor=8",
    "--qualities=0,1",
    "--views=3",
    "--rounds=3",
    "--threads=2",
    "--quiet",
];

fn pocketnerf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pocketnerf")).args(arguments).output().unwrap()
}

fn chart(out: &Path, more: &[&str]) -> Output {
    pocketnerf(&[&["chart", "--out", text(out)], &TINY[..], more].concat())
}

#[track_caller]
fn done(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The one line of a refusal.
#[track_caller]
fn refused(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    said
}

pub(crate) fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn points(out: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(out.join("points.json")).unwrap()).unwrap()
}

/// A column of `points.csv`.
fn column(out: &Path, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_path(out.join("points.csv")).unwrap();
    let at = reader.headers().unwrap().iter().position(|header| header == name).unwrap();
    reader.records().map(|record| record.unwrap()[at].to_owned()).collect()
}

#[test]
fn from_a_sweep_to_a_page_and_a_choice() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("chart");
    let peers = folder.path().join("peers.csv");
    let rows = "program,scene,width,height,psnr,ms_per_frame,bytes,source\n\
                other,builtin,50,50,21.5,3.5,100000,\"</script><b>a paper</b>\"\n\
                other,builtin,60,60,25,1,1,nobody\n\
                other,elsewhere,50,50,30,1,1,nobody\n";
    std::fs::write(&peers, rows).unwrap();
    let all = ["--precision=i8,f16", "--peers", text(&peers)];
    let said = done(&chart(&out, &all));
    assert!(said.contains("nerf against hash-grid, by ms_per_frame: BD-rate"), "{said}");
    let first = points(&out);
    let points_of_all = first["points"].as_array().unwrap();
    // Two models, two precisions, two qualities; the peers of this scene, one of another
    // size.
    assert_eq!(points_of_all.len(), 10);
    assert!(points_of_all[..8].iter().any(|point| point["frontier"] == true));
    for point in &points_of_all[..8] {
        assert_eq!((&point["scene"], &point["width"]), (&"builtin".into(), &50.into()));
        assert_eq!((&point["views"], &point["background"]), (&3.into(), &"1,1,1".into()));
        for known in [
            "psnr",
            "psnr_median",
            "psnr_p05",
            "psnr_min",
            "ssim",
            "depth_error",
            "ms_per_frame",
            "ms_low",
            "ms_high",
            "normalized_ms_per_frame",
            "spread",
            "rays_per_second",
            "samples_per_ray",
            "train_seconds",
            "bytes",
            "render_memory_bytes",
        ] {
            assert!(point[known].as_f64().unwrap().is_finite(), "{known}: {point}");
        }
        // Thumbnails have no five scales, and nobody gave weights.
        assert_eq!((&point["ms_ssim"], &point["lpips"]), (&Value::Null, &Value::Null));
        let [low, ms, high] =
            ["ms_low", "ms_per_frame", "ms_high"].map(|k| point[k].as_f64().unwrap());
        assert!(low <= ms && ms <= high, "{point}");
        assert_eq!(point["unsteady"], point["spread"].as_f64().unwrap() > 0.10);
        let picture = out.join("pictures").join(format!("{}.png", point["id"].as_str().unwrap()));
        let picture = image_file::open(picture).unwrap();
        assert_eq!((picture.width(), picture.height()), (150, 50));
    }
    assert_eq!(column(&out, "psnr").len(), 10);
    assert_eq!(column(&out, "unsteady").iter().filter(|flag| !flag.is_empty()).count(), 8);
    for key in ["cpu", "peak_gflops", "peak_gb_per_s", "simd"] {
        assert!(!first["machine"][key].is_null(), "{key}");
    }
    for name in ["chart.svg", "chart.png", "index.html"] {
        assert!(std::fs::metadata(out.join(name)).unwrap().len() > 10_000, "{name}");
    }

    page_works(&out.join("index.html"));
    what_a_chart_says_can_be_repeated(&points_of_all[0], &out);

    // Again: models and scores are kept, to the bit, times are measured again.
    let model = out
        .join("models")
        .join("builtin.steps20-downscale-factor8-nerf-D2-W16-batch-rays64.f32.pnerf");
    let trained = std::fs::metadata(&model).unwrap().modified().unwrap();
    done(&chart(&out, &all));
    assert_eq!(std::fs::metadata(&model).unwrap().modified().unwrap(), trained);
    let second = points(&out);
    let exact = |value: &Value| -> Vec<Value> {
        let own =
            value["points"].as_array().unwrap().iter().filter(|p| p["program"] == "pocketnerf");
        own.map(|p| serde_json::json!([p["id"], p["psnr"], p["ssim"], p["train_seconds"]]))
            .collect()
    };
    assert_eq!(exact(&first), exact(&second));
    assert_ne!(first["protocol"]["measured_at"], Value::Null);

    // Answers come from what is there; the choice can be kept in a file.
    let before = std::fs::read(out.join("points.json")).unwrap();
    let stored = folder.path().join("chosen.pnerf");
    let wish = ["--recommend=smallest=5", "--store", text(&stored)];
    let said = done(&chart(&out, &[&all[..], &wish].concat()));
    assert!(said.contains("smallest file with at least 5 dB: builtin."), "{said}");
    assert!(said.contains(": pocketnerf train builtin --out scene.pnerf --steps"), "{said}");
    assert_eq!(std::fs::read(out.join("points.json")).unwrap(), before);
    let bytes = std::fs::read(&stored).unwrap();
    let file = pocketnerf_formats::open_verified(&bytes).unwrap();
    assert!(matches!(file.about.quality, Some(0.0 | 1.0)));
    let none = chart(&out, &[&all[..], &["--recommend=fastest=99"]].concat());
    assert!(done(&none).contains("fastest with at least 99 dB: none of the points is"));
}

/// `eval` of the written model, and training again, give the chart's figures and bytes.
fn what_a_chart_says_can_be_repeated(point: &Value, out: &Path) {
    let model = out.join("models").join(format!(
        "builtin.{}.{}.pnerf",
        point["model"].as_str().unwrap(),
        point["precision"].as_str().unwrap()
    ));
    let command = point["train_command"].as_str().unwrap();
    let again = out.join("again.pnerf");
    let words: Vec<&str> = command
        .split_whitespace()
        .skip(1)
        .map(|word| if word == "scene.pnerf" { text(&again) } else { word })
        .collect();
    done(&pocketnerf(&[&words[..], &["--quiet", "--threads", "1"]].concat()));
    assert!(std::fs::read(&again).unwrap() == std::fs::read(&model).unwrap(), "{command}");
    // Its three views are 0, 4 and 8 of twelve.
    let command = point["eval_command"].as_str().unwrap();
    let words: Vec<&str> = command.split_whitespace().skip(1).chain(["--json"]).collect();
    let eval: Value = serde_json::from_str(&done(&pocketnerf(&words))).unwrap();
    let views = eval["per_view"].as_array().unwrap();
    let psnr = [0, 4, 8].map(|i: usize| views[i]["psnr"].as_f64().unwrap());
    let mean = psnr.iter().sum::<f64>() / 3.0;
    assert!((mean - point["psnr"].as_f64().unwrap()).abs() < 1e-9, "{mean} {point}");
    let least = psnr.into_iter().fold(f64::INFINITY, f64::min);
    assert_eq!(point["psnr_min"].as_f64().unwrap(), least);
    let worst = views.iter().find(|view| view["psnr"].as_f64() == Some(least)).unwrap();
    assert_eq!(point["worst_view"], worst["name"]);
}

/// A pixel that is larger than those of the photographs has several rays.
#[test]
fn smaller_pictures_are_antialiased_as_by_eval() {
    let folder = tempfile::tempdir().unwrap();
    let [model, out] = ["m.pnerf", "chart"].map(|name| folder.path().join(name));
    let small = "--downscale-factor 8 --exposure off --log2-hashmap-size 9 --n-levels 4";
    let train = format!("train builtin --steps 120 {small} --quiet --out {}", text(&model));
    done(&pocketnerf(&train.split(' ').collect::<Vec<_>>()));
    let chart = ["chart", "builtin", "--out", text(&out), "--models", text(&model)];
    let same = ["--downscale-factor=8,16", "--qualities=1", "--rounds=1", "--quiet"];
    done(&pocketnerf(&[&chart[..], &same].concat()));
    let points = points(&out);
    let [large, small] = [0, 1].map(|i| &points["points"][i]);
    assert_eq!((&large["width"], &small["width"]), (&50.into(), &25.into()));
    let eval = |point: &Value, more: &str| {
        let command = format!("{}{more} --json --quiet", point["eval_command"].as_str().unwrap());
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        let eval: Value = serde_json::from_str(&done(&pocketnerf(&words))).unwrap();
        eval["psnr"].as_f64().unwrap()
    };
    for point in [large, small] {
        let [ours, theirs] = [point["psnr"].as_f64().unwrap(), eval(point, "")];
        assert!((ours - theirs).abs() < 1e-9, "{ours} {theirs}");
    }
    let [smooth, jagged] = ["", " --antialias off"].map(|more| eval(small, more));
    // Little, of a model of so few steps.
    assert!(jagged < smooth - 0.05, "{jagged} {smooth}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_chart_goes_on_where_it_stopped() {
    use std::os::unix::process::CommandExt;
    use std::time::{Duration, Instant};

    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("chart");
    let tiny =
        "--downscale-factor 8 --exposure off --log2-hashmap-size 8 --n-levels 4 --hidden-width 16";
    let [first, second] = [5, 400].map(|steps| format!("--train=--steps {steps} {tiny}"));
    let arguments = [
        "chart",
        "--out",
        text(&out),
        &first,
        &second,
        "--downscale-factor=8",
        "--views=1",
        "--rounds=1",
        "--quiet",
    ];
    let models = out.join("models");
    let has = |start: &str, end: &str| {
        let names = std::fs::read_dir(&models).into_iter().flatten().flatten();
        names
            .map(|entry| entry.file_name().into_string().unwrap())
            .find(|name| name.starts_with(start) && name.ends_with(end))
    };
    // While the second model's views are read, and while it is trained: as a terminal signals,
    // both programs, and as a supervisor may, this one alone.
    for (wait, signal, both) in [(50, "-INT", true), (800, "-INT", true), (800, "-TERM", false)] {
        if let Some(record) = has("builtin.steps400", ".json") {
            std::fs::remove_file(models.join(record)).unwrap();
        }
        let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
        let child = command.args(arguments).process_group(0).spawn().unwrap();
        let begun = Instant::now();
        while has("builtin.steps400", ".json").is_none() {
            assert!(begun.elapsed() < Duration::from_secs(120), "the second model never begins");
            std::thread::sleep(Duration::from_millis(20));
        }
        std::thread::sleep(Duration::from_millis(wait));
        let id = format!("{}{}", if both { "-" } else { "" }, child.id());
        assert!(Command::new("kill").args([signal, "--", &id]).status().unwrap().success());
        assert_eq!(child.wait_with_output().unwrap().status.code(), Some(130), "{wait} ms");
        assert!(!out.join("points.json").exists());
        assert_eq!(has("builtin.steps400", ".f32.pnerf"), None);
    }
    let whole = models.join("builtin.steps5-downscale-factor8-exposureoff-T8-L4-W16.f32.pnerf");
    let trained = std::fs::metadata(&whole).unwrap().modified().unwrap();

    done(&pocketnerf(&arguments));
    assert_eq!(std::fs::metadata(&whole).unwrap().modified().unwrap(), trained);
    assert_eq!(points(&out)["points"].as_array().unwrap().len(), 6);
    assert_eq!(has("builtin.steps400", ".ckpt.pnerf"), None);
}

#[test]
fn what_is_wrong_is_said_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("chart");
    let at = |name: &str| folder.path().join(name);
    let expect = |more: &[&str], expected: &str| {
        let said = refused(&chart(&out, more));
        assert!(said.contains(expected), "{said}\n{expected}");
        assert!(!out.exists(), "{expected}");
    };
    std::fs::write(at("peers.csv"), "program,scene,width,height,fps\na,b,1,1,3\n").unwrap();
    expect(&["--peers", text(&at("peers.csv"))], "peers.csv:2: unknown field `fps`");
    expect(&["--lpips-weights", text(&at("none.npz"))], "none.npz: ");
    expect(&["--train=--colour red"], "unexpected argument '--colour' found");
    expect(&["--train=--steps 60 --precision f16"], "--precision: leave it out, the chart says");
    expect(&["--x=psnr"], "--x psnr: expected a cost");
    expect(&["--y=bytes"], "--y bytes: expected how good pictures are");
    expect(&["--split=train"], "--split train: expected val or test");
    expect(
        &["--recommend=fastest=1", "--recommend=smallest=1", "--store=m.pnerf"],
        "one --recommend",
    );
    expect(&[text(&at("nothing"))], "nothing");

    // A Blender dataset that has no test split.
    let scene = at("scene");
    std::fs::create_dir(&scene).unwrap();
    image::RgbImage::new(16, 16).save(scene.join("a.png")).unwrap();
    let frame =
        r#"{"file_path": "a", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}"#;
    let transforms = format!(r#"{{"camera_angle_x": 0.7, "frames": [{frame}]}}"#);
    std::fs::write(scene.join("transforms_train.json"), transforms).unwrap();
    expect(&[text(&scene)], "transforms_test.json");

    // A model of the built-in scene for that dataset.
    let model = at("m.pnerf");
    let steps = [
        "--steps=5",
        "--downscale-factor=16",
        "--exposure=off",
        "--log2-hashmap-size=8",
        "--quiet",
    ];
    done(&pocketnerf(&[&["train", "builtin", "--out", text(&model)], &steps[..]].concat()));
    std::fs::copy(scene.join("transforms_train.json"), scene.join("transforms_test.json")).unwrap();
    let taken = ["chart", text(&scene), "--out", text(&out), "--models", text(&model)];
    let said = refused(&pocketnerf(&taken));
    assert!(said.contains("m.pnerf: a model of \"built-in scene\", expected one of"), "{said}");
    assert!(!out.exists());
    // For its own it is taken.
    let taken = ["chart", "builtin", "--out", text(&out), "--models", text(&model)];
    let few = ["--downscale-factor=16", "--rounds=1", "--views=1", "--quiet", "--json"];
    let said = done(&pocketnerf(&[&taken[..], &few].concat()));
    let said: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(said["points"].as_array().unwrap().len(), 3);
    assert_eq!(said["points"][0]["model"], "m");
}
