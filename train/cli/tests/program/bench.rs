//! `pocketnerf bench`.

use std::process::{Command, Output};

use serde_json::Value;

fn bench(options: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
    command.arg("bench").args(options.split_whitespace()).output().unwrap()
}

fn positive(value: &Value, what: &str) -> f64 {
    let number = value.as_f64().unwrap_or_else(|| panic!("{what}: {value}"));
    assert!(number > 0.0 && number.is_finite(), "{what}: {number}");
    number
}

fn check_stages(part: &Value, names: &[&str]) {
    let stages = part["stages"].as_array().unwrap();
    let found: Vec<_> = stages.iter().map(|stage| stage["name"].as_str().unwrap()).collect();
    assert_eq!(found, names);
    let mut sum = 0.0;
    for stage in stages {
        let name = stage["name"].as_str().unwrap();
        sum += stage["share"].as_f64().unwrap();
        // What is left of the time may be less than nothing, where clocks disagree.
        let time = stage["ns_per_sample"].as_f64().unwrap();
        assert!(time.is_finite() && (time > 0.0 || name == "rest"), "{stage}");
        assert!(stage["unit"].is_string() && stage["bound"].is_string(), "{stage}");
        for key in ["gflops", "gb_per_s", "gathers_per_second", "fraction_of_peak", "ns_per_unit"] {
            let value = stage.get(key).unwrap_or_else(|| panic!("{key}: {stage}"));
            if !value.is_null() && name != "rest" {
                positive(value, &format!("{name} {key}"));
            }
        }
        assert_eq!(stage["bound"] == "none", stage["fraction_of_peak"].is_null(), "{stage}");
    }
    assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    positive(&part["fraction_of_bounds"], "fraction of bounds");
}

#[test]
fn everything_is_there() {
    let output = bench("--quick --json --quiet --threads 2");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && error.is_empty(), "{error}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    for key in ["clock_ghz", "clock_ghz_at_end", "peak_gflops", "peak_gb_per_s", "fma_fraction"] {
        positive(&report[key], key);
    }
    assert_eq!(report["threads"], 2);
    for (curve, size, keys) in [
        ("gathers", 5, ["per_second_one_thread", "per_second_all"]),
        ("streams", 3, ["gb_per_s_one_thread", "gb_per_s_all"]),
    ] {
        let points = report[curve].as_array().unwrap();
        assert_eq!(points.len(), size);
        for point in points {
            for key in keys.iter().chain(&["bytes"]) {
                positive(&point[key], key);
            }
        }
    }
    let rendering = &report["rendering"];
    let stages = [
        "interpolate",
        "camera and way",
        "march",
        "encode",
        "density network",
        "composite",
        "colour network",
        "rest",
    ];
    check_stages(rendering, &stages);
    for key in [
        "frames_per_second",
        "samples_per_ray",
        "samples_per_hit_ray",
        "samples_per_ray_every_pixel",
        "seconds_per_frame_every_pixel",
        "rows_per_pixel",
        "interpolated_share",
        "ns_per_pixel_outside",
        "ns_per_pixel_empty",
        "ns_per_pixel_missed",
    ] {
        positive(&rendering[key], key);
    }
    for key in ["frame", "fma", "bandwidth"] {
        positive(&rendering["scaling"][key], key);
    }
    let variants = rendering["variants"].as_array().unwrap();
    assert!(variants.iter().any(|v| v["simd"] == "portable"));
    assert_eq!(variants.last().unwrap()["tuning"], "small");
    let training = [
        "pixels",
        "march",
        "encode",
        "density network",
        "composite",
        "shade and loss",
        "encode again",
        "network backward",
        "table scatter",
        "gradient reduction",
        "Adam and rounding",
        "occupancy",
        "rest",
    ];
    check_stages(&report["training"], &training);
    positive(&report["training"]["samples_per_second"], "samples per second");
}

#[test]
fn what_cannot_be_measured_is_refused_at_once() {
    for (options, message) in
        [("nowhere.pnerf", "nowhere.pnerf: cannot be read"), ("--data nowhere", "nowhere")]
    {
        let output = bench(options);
        assert_eq!(output.status.code(), Some(1), "{options}");
        let line = String::from_utf8_lossy(&output.stderr);
        assert!(line.contains(message) && line.matches('\n').count() == 1, "{line}");
    }
    for options in ["--width 0", "--steps 3"] {
        assert_eq!(bench(options).status.code(), Some(2), "{options}");
    }
}
