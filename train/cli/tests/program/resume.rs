//! `pocketnerf train`: saved, interrupted and resumed.

#[cfg(unix)]
use std::io::{BufRead, BufReader};
#[cfg(unix)]
use std::ops::Range;
use std::process::{Command, Stdio};
#[cfg(unix)]
use std::time::{Duration, Instant};

use pocketnerf_core::SimdLevel;
use pocketnerf_train::picture::image_file;
use serde_json::Value;

use crate::place::{Place, TRAIN, text};

#[test]
fn saved_and_resumed() {
    let place = Place::new();
    let result = place.ok(&format!("{TRAIN} --steps 60 --out whole.pnerf"));
    assert_eq!((&result["steps"], &result["restarts"]), (&60.into(), &0.into()));
    // Every step saves; the last checkpoint is that of the last step.
    place.ok(&format!("{TRAIN} --steps 60 --out saved.pnerf --save-every 0.000001"));
    assert!(place.bytes("saved.pnerf") == place.bytes("whole.pnerf"));
    let checkpoint = place.ok("info saved.ckpt.pnerf --json");
    assert_eq!(checkpoint["checkpoint"]["step"], 60);
    assert_eq!(checkpoint["checkpoint"]["steps"], 60);
    assert_eq!(checkpoint["checkpoint"]["seed"], 5);
    assert_eq!(checkpoint["precision"], "f32");
    assert!(place.ok("info saved.pnerf --json")["checkpoint"].is_null());
    place.ok("render saved.ckpt.pnerf --width 8 --height 8 --out view.png");
    place.ok("train data --resume saved.ckpt.pnerf --out again.pnerf");
    assert!(place.bytes("again.pnerf") == place.bytes("whole.pnerf"));

    // Options that say the same are taken, others are not.
    let resume = "train data --quiet --resume saved.ckpt.pnerf --out x.pnerf";
    place.ok(&format!("{resume} --steps 60 --seed 5 --batch-rays 64"));
    let found = "saved.ckpt.pnerf: trained with";
    for (options, stored) in [
        ("--steps 90", "--steps 60"),
        ("--seconds 9.0", "no --seconds"),
        ("--seed 6", "--seed 5"),
        ("--batch-rays 65", "--batch-rays 64"),
        ("--downscale-factor 2", "--downscale-factor 1"),
        ("--near 0.5", "--near 0.0"),
        ("--far 9.0", "no --far"),
        ("--log2-hashmap-size 10", "--log2-hashmap-size 9"),
    ] {
        let option = options.split(' ').next().unwrap();
        assert_eq!(
            place.line(&format!("{resume} {options}")),
            format!(
                "{found} {stored}, but {options} was given; \
                 leave {option} out when resuming, or train from scratch without --resume"
            )
        );
    }
    let line = place.line(&format!("{resume} --aabb 0,0,0,1,1,1 --background white"));
    // The box that was found is that of the run.
    assert!(line.starts_with(&format!("{found} --aabb [[")), "{line}");
    assert!(line.contains("]], but --aabb [[0.0, "), "{line}");

    // Another dataset, and files that are no checkpoints.
    let image = place.path("data/3.png");
    let mut picture = image_file::open(&image).unwrap().to_rgba8();
    picture.get_pixel_mut(2, 2).0[0] ^= 1;
    picture.save(&image).unwrap();
    let line = place.line(resume);
    assert!(line.starts_with("saved.ckpt.pnerf: trained on \"data\" (fingerprint "), "{line}");
    assert!(line.ends_with("give the dataset that the run began with, unchanged"), "{line}");
    let line = place.line("train data --resume whole.pnerf --out x.pnerf");
    assert!(line.starts_with("whole.pnerf: this is a model, expected a checkpoint; "), "{line}");
    let line = place.line("train data --resume none.pnerf --out x.pnerf");
    assert!(line.starts_with("none.pnerf: cannot be read: "), "{line}");
}

/// A checkpoint knows its vector instructions, with which the run goes on by itself.
#[test]
fn resumed_with_the_same_vector_instructions() {
    let place = Place::new();
    let train = format!("{TRAIN} --steps 40 --simd portable");
    place.ok(&format!("{train} --out whole.pnerf --save-every 0.000001"));
    let again = place.ok("train data --json --resume whole.ckpt.pnerf --out again.pnerf");
    assert!(place.bytes("again.pnerf") == place.bytes("whole.pnerf"));
    let only_steps = |warning: &Value| warning.as_str().unwrap().starts_with("only 40 steps");
    assert!(again["warnings"].as_array().unwrap().iter().all(only_steps), "{again}");
    // Others are taken, and it is said.
    let best = SimdLevel::detect();
    if best != SimdLevel::Portable {
        let resume = "train data --json --resume whole.ckpt.pnerf --out other.pnerf";
        let other = place.ok(&format!("{resume} --simd {best}"));
        let warning = other["warnings"][0].as_str().unwrap();
        assert_eq!(
            warning,
            format!(
                "whole.ckpt.pnerf: trained with portable so far, resumed with {best}: the model \
                 will differ by rounding; expected --simd portable for the same bytes"
            )
        );
    }
}

/// A signal that comes when all steps are taken.
#[cfg(unix)]
#[test]
fn interrupted_while_the_model_is_finished() {
    let place = Place::new();
    let train = TRAIN.replace("--quiet ", "");
    let whole = format!("{train} --steps 600 --out whole.pnerf");
    place.ok(&whole);
    let mut command = place.command(&whole.replace("whole", "cut"));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    while said.next().unwrap().unwrap() != "finishing the model" {}
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let line = said.next().unwrap().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{line}");
    let resume = "train data --out cut.pnerf --resume cut.ckpt.pnerf";
    let expected =
        format!("pocketnerf: interrupted at step 600, saved; resume with: pocketnerf {resume}");
    assert_eq!(line, expected);
    assert!(!place.path("cut.pnerf").exists());
    place.ok(&format!("{resume} --json"));
    assert!(place.bytes("cut.pnerf") == place.bytes("whole.pnerf"));
}

#[test]
fn numbers_that_make_no_sense() {
    let place = Place::new();
    for options in ["--save-every 0", "--seconds 0", "--batch-rays 0", "--batch-rays 9999999"] {
        let line = place.line(&format!("train data --out x.pnerf {options}"));
        assert!(line.starts_with(&format!("{options}: expected ")), "{line}");
    }
    for options in ["--near 2 --far 2", "--near 3 --far 2"] {
        let line = place.line(&format!("train data --out x.pnerf {options}"));
        assert_eq!(line, format!("{options}: expected 0 or more, and far beyond near"));
    }
    // Wrong usage: the program names the values that it takes.
    for (options, range) in [
        ("--log2-hashmap-size 99", "3..=24"),
        ("--threads 0", "1..=1024"),
        ("--threads 100000000", "1..=1024"),
        ("--steps 0", "1.."),
        ("--aabb 0,0,0,1,1,0", "the first three below the others"),
        ("--aabb 0,0,0,1,1,inf", "the first three below the others"),
    ] {
        let output = place.run(&format!("train data --out x.pnerf {options}"));
        assert_eq!(output.status.code(), Some(2), "{options}");
        assert!(text(&output.stderr).contains(range), "{options}: {}", text(&output.stderr));
    }
    assert!(!place.path("x.pnerf").exists());
}

/// Who reads the output may stop reading.
#[cfg(unix)]
#[test]
fn a_broken_pipe_is_no_fault() {
    let place = Place::new();
    let mut child = place.command("info data").stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

/// Ctrl-C, and what supervisors and closing terminals send.
#[cfg(unix)]
#[test]
fn interrupted_and_resumed() {
    let place = Place::new();
    let steps = 400;
    place.ok(&format!("{TRAIN} --steps {steps} --out whole.pnerf"));
    // Each goes on from what the one before has left.
    let begin = format!("{TRAIN} --steps {steps}");
    let go_on = "train data --resume cut.ckpt.pnerf --quiet --json";
    let mut step = 0;
    for (command, signal) in [(&begin[..], "-INT"), (go_on, "-TERM"), (go_on, "-HUP")] {
        step = interrupted_by(signal, command, &place, step..steps);
    }
    let result = place.ok(&format!("{go_on} --out cut.pnerf --threads 3"));
    assert_eq!(result["steps"], steps);
    assert!(place.bytes("cut.pnerf") == place.bytes("whole.pnerf"));
    // No temporary file is left.
    let names = std::fs::read_dir(place.0.path()).unwrap().count();
    assert_eq!(names, 4, "data, two models and a checkpoint");

    nothing_is_lost_where_nothing_can_be_written(&place, steps);
}

/// A run that a signal ends after some of its steps; the step it came to.
#[cfg(unix)]
fn interrupted_by(signal: &str, command: &str, place: &Place, steps: Range<u64>) -> u64 {
    let checkpoint = place.path("cut.ckpt.pnerf");
    let written = || std::fs::metadata(&checkpoint).and_then(|file| file.modified()).ok();
    let before = written();
    let options = format!("{command} --out cut.pnerf --save-every 0.01");
    let child =
        place.command(&options).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Its first checkpoint says that training has begun.
    let begun = Instant::now();
    while written() == before && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    let pid = child.id().to_string();
    assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{line}");
    assert!(output.stdout.is_empty() && !place.path("cut.pnerf").exists());
    let resume = "train data --out cut.pnerf --resume cut.ckpt.pnerf";
    assert!(line.starts_with("pocketnerf: interrupted at step "), "{line}");
    assert!(line.ends_with(&format!(", saved; resume with: pocketnerf {resume}\n")), "{line}");
    let step = place.ok("info cut.ckpt.pnerf --json")["checkpoint"]["step"].as_u64().unwrap();
    assert!(line.contains(&format!("at step {step},")), "{line}");
    assert!(steps.start < step && step < steps.end, "{steps:?} {line}");
    step
}

/// Folders take the places of model and checkpoint while training runs.
#[cfg(unix)]
fn nothing_is_lost_where_nothing_can_be_written(place: &Place, steps: u64) {
    let options = format!("{TRAIN} --steps {steps} --out lost.pnerf --save-every 0.01");
    let elsewhere = place.path("elsewhere");
    std::fs::create_dir(&elsewhere).unwrap();
    let mut command = place.command(&options);
    command.env("TMPDIR", &elsewhere).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    let checkpoint = place.path("lost.ckpt.pnerf");
    let begun = Instant::now();
    // A checkpoint may be replaced between the two calls.
    while std::fs::remove_file(&checkpoint).and_then(|()| std::fs::create_dir(&checkpoint)).is_err()
    {
        assert!(begun.elapsed() < Duration::from_secs(60), "there is no checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
    std::fs::create_dir(place.path("lost.pnerf")).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    let lines: Vec<&str> = said.lines().collect();
    let [warning, few, failure] = lines[..] else { panic!("{said}") };
    assert!(warning.starts_with("warning: lost.ckpt.pnerf: this is a folder"), "{said}");
    assert!(few.starts_with("warning: only 400 steps were taken"), "{said}");
    assert!(failure.starts_with("pocketnerf: lost.pnerf: this is a folder"), "{said}");
    // The command that is given writes the model, once there is a place for it.
    let (_, command) = failure.split_once("; training is saved, write the model with: ").unwrap();
    let expected =
        format!("pocketnerf train data --out lost.pnerf --resume {}/", elsewhere.display());
    assert!(command.starts_with(&expected) && command.ends_with("-lost.ckpt.pnerf"), "{said}");
    for folder in ["lost.pnerf", "lost.ckpt.pnerf"] {
        std::fs::remove_dir(place.path(folder)).unwrap();
    }
    place.ok(command.strip_prefix("pocketnerf ").unwrap());
    assert!(place.bytes("lost.pnerf") == place.bytes("whole.pnerf"));
}
