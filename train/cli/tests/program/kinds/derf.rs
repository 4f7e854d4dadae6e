//! `train --method derf`.

use super::{goes_on_after_an_interruption, refused, taken_by_every_command};

#[test]
fn every_command_takes_heads() {
    let info = taken_by_every_command("derf", "--width 16 --depth 2 --heads 3");
    // Layers of 63, 16, 1; 16 + 27, 8, 3 values, and the feature; three sites.
    let head = 64 * 16 + 17 * 16 + 17 + 17 * 16 + 44 * 8 + 9 * 3;
    assert_eq!(info["parameters"].as_u64().unwrap(), 3 * head + 9);
}

#[test]
fn a_run_is_interrupted_and_goes_on() {
    goes_on_after_an_interruption("derf", "--width 16 --depth 2 --heads 2");
}

#[test]
fn options_of_other_kinds_are_refused() {
    let lines = [
        ("--heads 4", "--heads: give --method derf too"),
        ("--method derf --voxels 64", "--voxels: give --method plenoxels too"),
        ("--method derf --n-levels 8", "--n-levels: for --method hash-grid alone"),
        ("--method derf --sampling hierarchical", "--sampling: for --method nerf alone"),
        ("--method derf --gaussian 16,2", "--gaussian: for --method nerf alone"),
    ];
    refused("derf", &lines, &["--heads 0", "--heads 65"]);
}
