//! `train --method planes`.

use super::{goes_on_after_an_interruption, refused, taken_by_every_command};

#[test]
fn every_command_takes_planes() {
    let info = taken_by_every_command("planes", "--plane-resolution 64");
    assert_eq!(info["precision"], "i8 tables, f16 networks");
    // Six planes and six lines of eight values an entry, and networks.
    let tables = 6 * 8 * (64 * 64 + 64);
    let parameters = info["parameters"].as_u64().unwrap();
    assert!((tables..tables + 20_000).contains(&parameters), "{parameters}");
}

#[test]
fn a_run_is_interrupted_and_goes_on() {
    goes_on_after_an_interruption("planes", "--plane-resolution 128 --components 32");
}

#[test]
fn options_of_other_kinds_are_refused() {
    let lines = [
        ("--plane-resolution 128", "--plane-resolution: give --method planes too"),
        ("--components 16", "--components: give --method planes too"),
        ("--method planes --n-levels 8", "--n-levels: for --method hash-grid alone"),
        ("--method planes --voxels 64", "--voxels: give --method plenoxels too"),
        ("--method planes --max-bytes 100000", "--max-bytes: for --method hash-grid alone"),
        ("--method planes --refine-poses", "--refine-poses: for --method hash-grid alone"),
    ];
    let out_of_range = ["--plane-resolution 8", "--plane-resolution 2000", "--components 24"];
    refused("planes", &lines, &out_of_range);
}
