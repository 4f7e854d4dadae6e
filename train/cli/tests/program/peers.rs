//! The scripts of tests/peers/: other programs' outputs become points of the chart.

use std::path::Path;
use std::process::{Command, Output};

use pocketnerf_cli::chart::{Point, peers};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/peers");
/// Script, sample.
const SCRIPTS: [(&str, &str); 4] = [
    ("instant_ngp", "instant_ngp.txt"),
    ("nerfstudio", "nerfstudio.json"),
    ("torch_ngp", "torch_ngp.txt"),
    ("brush", "brush.txt"),
];
const SIZE: [&str; 6] = ["--scene", "lego", "--width", "800", "--height", "800"];

fn python_is_missing() -> bool {
    let missing = Command::new("python3").arg("--version").output().is_err();
    if missing {
        let required = std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_some();
        assert!(!required, "no python3, and POCKETNERF_REQUIRE_TOOLS is set");
        println!("no python3: skipped");
    }
    missing
}

fn run(script: &str, output: &Path, options: &[&str]) -> Output {
    let mut command = Command::new("python3");
    // Without a folder of compiled modules beside the scripts.
    command.arg("-B").arg(format!("{FOLDER}/{script}.py")).arg(output).args(options);
    command.output().unwrap()
}

fn sample(name: &str) -> std::path::PathBuf {
    Path::new(FOLDER).join("samples").join(name)
}

/// The point that standard output holds.
#[track_caller]
fn point(script: &str, file: &str, options: &[&str]) -> Point {
    let output = run(script, &sample(file), &[&SIZE[..], options].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("peers.csv");
    std::fs::write(&csv, &output.stdout).unwrap();
    let mut points = peers::read(&csv).unwrap();
    assert_eq!(points.len(), 1);
    points.remove(0)
}

/// The one line that says why not.
#[track_caller]
fn refused(script: &str, file: &Path, options: &[&str]) -> String {
    let output = run(script, file, options);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(output.stdout.is_empty() && said.contains(", expected "), "{said}");
    said
}

#[test]
fn outputs_become_points() {
    if python_is_missing() {
        return;
    }
    let options = ["--split", "test", "--views", "200", "--machine", "a GPU", "--bytes", "1000"];
    let ngp = point("instant_ngp", "instant_ngp.txt", &options);
    assert_eq!((&*ngp.program, &*ngp.scene, &*ngp.background), ("instant-ngp", "lego", "0,0,0"));
    assert_eq!((ngp.width, ngp.height, ngp.views, ngp.bytes), (800, 800, Some(200), Some(1000)));
    assert_eq!((ngp.psnr, ngp.ssim), (Some(35.41726839164721), Some(0.9783125465512276)));
    assert_eq!((ngp.lpips, ngp.ms_per_frame, ngp.train_seconds), (None, None, None));
    assert_eq!((&*ngp.split, ngp.machine.as_deref()), ("test", Some("a GPU")));
    assert_eq!(ngp.source.as_deref(), Some("scripts/run.py --test_transforms"));

    let studio = point("nerfstudio", "nerfstudio.json", &["--background", "white"]);
    assert_eq!((&*studio.program, &*studio.model), ("nerfstudio", "nerfacto lego"));
    assert_eq!((studio.psnr, studio.ssim), (Some(28.51324462890625), Some(0.9412736296653748)));
    assert_eq!((studio.lpips, &*studio.background), (Some(0.04870128259062767), "1,1,1"));
    assert_eq!((studio.ms_per_frame, studio.rays_per_second), (Some(500.0), Some(1_280_000.0)));
    assert!(studio.source.unwrap().contains("metrics"), "the time is not that of rendering");

    let torch = point("torch_ngp", "torch_ngp.txt", &["--train-seconds", "300"]);
    assert_eq!((&*torch.program, &*torch.background), ("torch-ngp", "1,1,1"));
    assert_eq!((torch.psnr, torch.lpips, torch.ssim), (Some(33.124517), Some(0.02731), None));
    assert_eq!((torch.train_seconds, &*torch.split), (Some(300.0), ""));

    let brush = point("brush", "brush.txt", &[]);
    assert_eq!((&*brush.program, brush.views), ("brush", Some(24)));
    assert_eq!((brush.psnr, brush.ssim), (Some(27.163542), Some(0.8619437)));
}

#[test]
fn an_option_counts_more_than_the_output() {
    if python_is_missing() {
        return;
    }
    let options =
        ["--ms-per-frame", "40", "--background", "0.5,0.5,1", "--source", "\u{e9}t\u{e9}"];
    let studio = point("nerfstudio", "nerfstudio.json", &options);
    assert_eq!((studio.ms_per_frame, studio.frames_per_second), (Some(40.0), Some(25.0)));
    assert_eq!((&*studio.background, studio.source.as_deref()), ("0.5,0.5,1", Some("été")));
}

#[test]
fn points_are_added_to_a_file() {
    if python_is_missing() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("peers.csv");
    let append = ["--append", csv.to_str().unwrap()];
    for (script, file) in SCRIPTS {
        let output = run(script, &sample(file), &[&SIZE[..], &append].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout.is_empty());
    }
    let programs: Vec<_> = peers::read(&csv).unwrap().into_iter().map(|p| p.program).collect();
    assert_eq!(programs, ["instant-ngp", "nerfstudio", "torch-ngp", "brush"]);

    // Somebody's own columns stay, in their order, and the last line may lack its end.
    let options = [&SIZE[..], &append].concat();
    let own = "source,psnr,program,height,width,scene,ssim,background,views\na,30,b,8,8,c,,,";
    std::fs::write(&csv, own).unwrap();
    assert!(run("brush", &sample("brush.txt"), &options).status.success());
    let points = peers::read(&csv).unwrap();
    assert_eq!((points.len(), points[1].psnr), (2, Some(27.163542)));
    std::fs::write(&csv, "program,psnr\n").unwrap();
    assert!(refused("brush", &sample("brush.txt"), &options).contains("peers.csv: columns"));
    assert_eq!(std::fs::read(&csv).unwrap(), b"program,psnr\n");
}

#[test]
fn a_wrong_file_gives_one_line() {
    if python_is_missing() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a\nfile");
    for (i, (script, name)) in SCRIPTS.into_iter().enumerate() {
        let other = sample(SCRIPTS[(i + 1) % SCRIPTS.len()].1);
        assert!(refused(script, &other, &SIZE).starts_with(other.to_str().unwrap()));
        refused(script, &folder.path().join("nowhere"), &SIZE);
        refused(script, folder.path(), &SIZE);
        // Cut, empty, without a text in it, and with what is no figure of a chart.
        let whole = std::fs::read_to_string(sample(name)).unwrap();
        let bad = |figure: &str| {
            let known = ["35.41726839164721", "28.51324462890625", "33.124517", "27.163542"];
            whole.replace(known[i], figure).into_bytes()
        };
        let wrong =
            [whole.as_bytes()[..40].to_vec(), vec![], vec![0, 255, 10], bad("NaN"), bad("-1")];
        for bytes in wrong {
            std::fs::write(&file, bytes).unwrap();
            refused(script, &file, &SIZE);
        }
    }
    for text in ["[]", "{\"results\": 3}", "{\"results\": {\"psnr\": \"x\\ny\"}}"] {
        std::fs::write(&file, text).unwrap();
        refused("nerfstudio", &file, &SIZE);
    }
    std::fs::write(&file, "[".repeat(100_000)).unwrap();
    refused("nerfstudio", &file, &SIZE);
    let small = ["--scene", "lego", "--width", "400", "--height", "400"];
    assert!(refused("nerfstudio", &sample("nerfstudio.json"), &small).contains("640000 pixels"));
    // An evaluation that did not finish does not count, nor do its figures.
    let text = "++> Evaluate at epoch 1 ...\nPSNR = 30.0\n++> Evaluate at epoch 2 ...\n";
    std::fs::write(&file, text).unwrap();
    assert!(refused("torch_ngp", &file, &SIZE).contains("0 finished"));
}
