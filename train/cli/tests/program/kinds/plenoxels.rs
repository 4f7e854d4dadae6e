//! `train --method plenoxels`.

use super::{goes_on_after_an_interruption, refused, taken_by_every_command};

#[test]
fn every_command_takes_voxels() {
    let info = taken_by_every_command("plenoxels", "--voxels 64");
    assert_eq!(info["precision"], "i8");
    assert!(info["parameters"].as_u64().unwrap() > 64 * 16);
}

#[test]
fn a_run_is_interrupted_and_goes_on() {
    goes_on_after_an_interruption("plenoxels", "--voxels 256 --sh-bands 1");
}

#[test]
fn options_of_other_kinds_are_refused() {
    let lines = [
        ("--voxels 128", "--voxels: give --method plenoxels too"),
        ("--sh-bands 2", "--sh-bands: give --method plenoxels too"),
        ("--method plenoxels --n-levels 8", "--n-levels: for --method hash-grid alone"),
        (
            "--method plenoxels --profile fast",
            "--profile fast: for --method hash-grid and planes alone",
        ),
        (
            "--method plenoxels --max-bytes 100000",
            "--max-bytes: for --method hash-grid and planes alone",
        ),
        (
            "--method plenoxels --refine-poses",
            "--refine-poses: for --method hash-grid and planes alone",
        ),
    ];
    refused("plenoxels", &lines, &["--voxels 130", "--voxels 1024", "--sh-bands 4"]);
}
