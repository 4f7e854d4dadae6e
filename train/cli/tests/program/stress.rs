//! `pocketnerf stress`.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn stress(out: &Path, more: &[&str]) -> Output {
    let tiny = ["--quick", "--steps=40", "--downscale-factor=20", "--threads=2", "--quiet"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
    command.arg("stress").arg("--out").arg(out).args(tiny).args(more).output().unwrap()
}

#[track_caller]
fn rows(output: &Output) -> Vec<Value> {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let object: Value = serde_json::from_slice(&output.stdout).unwrap();
    object["rows"].as_array().unwrap().clone()
}

#[test]
fn what_is_spoilt_is_measured_and_what_is_said_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("table");
    let modes = "--modes=cut-short,views,test-background,smaller-pictures,space,box-size";
    let first = rows(&stress(&out, &["--json", modes]));
    // The still life is no forward-facing capture.
    let names: Vec<&str> = first.iter().map(|row| row["mode"].as_str().unwrap()).collect();
    let expected = ["cut-short", "views", "test-background", "smaller-pictures", "box-size"];
    assert_eq!(names, expected);
    for row in &first {
        let loss = row["reference_psnr"].as_f64().unwrap() - row["psnr"].as_f64().unwrap();
        assert!((row["value"].as_f64().unwrap() - loss).abs() < 1e-9, "{row}");
        let within = loss <= row["bar"].as_f64().unwrap();
        let said = row["warning"].is_string();
        let verdict = ["fails", "says-so", "within"][if within { 2 } else { usize::from(said) }];
        assert_eq!(row["verdict"], verdict, "{row}");
    }
    // One of sixty images ends in the middle; twelve photographs are far apart; half a box cuts
    // the scene off.
    let warning = |i: usize| first[i]["warning"].as_str().unwrap_or_default();
    assert!(warning(0).contains("1 of 60 images are left out"), "{}", warning(0));
    assert!(warning(1).contains("12 photographs"), "{}", warning(1));
    assert_eq!(first[2]["warning"], Value::Null);
    assert!(first[4]["value"].as_f64().unwrap() > 1.0, "{}", first[4]);
    let page = std::fs::read_to_string(out.join("index.html")).unwrap();
    assert!(page.contains("cut-short") && page.contains("data:image/jpeg;base64,"));
    assert!(std::fs::read_to_string(out.join("stress.svg")).unwrap().contains("views"));
    // The same command measures nothing again, and rows of others stand beside ours.
    let model = out.join("builtin.planes/usual.views12.pnerf");
    let written = std::fs::metadata(&model).unwrap().modified().unwrap();
    let table = std::fs::read_to_string(out.join("stress.csv")).unwrap();
    let peers = folder.path().join("peers.csv");
    std::fs::write(&peers, table.replace("planes", "other-program")).unwrap();
    let again = rows(&stress(&out, &["--json", modes, "--peers", peers.to_str().unwrap()]));
    assert_eq!(again[..first.len()], first);
    assert_eq!(again.len(), 2 * first.len());
    assert_eq!(again[first.len()]["method"], "other-program");
    assert_eq!(std::fs::metadata(&model).unwrap().modified().unwrap(), written);
}

#[test]
fn what_cannot_be_spoilt_is_refused_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("table");
    for (arguments, expected) in [
        (&["--modes=nonsense"][..], "--modes nonsense: not known"),
        (&["--peers=nowhere.csv"], "nowhere.csv: cannot be read"),
        (&["builtin", "builtin"], "builtin: given twice"),
        (&["nowhere"], "nowhere"),
    ] {
        let output = stress(&out, arguments);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains(expected) && said.trim_end().lines().count() == 1, "{said}");
    }
    let list = stress(&out, &["--list"]);
    let list = String::from_utf8(list.stdout).unwrap();
    assert!(list.lines().count() >= 22 && list.contains("pose-rotation: "), "{list}");
}
