//! Tells the program which commit it was built of, for the provenance of charts.

use std::process::Command;

fn main() {
    // Whatever changes the answer.
    for path in [
        "../../.git/HEAD",
        "../../.git/index",
        "src",
        "../src",
        "../../core/src",
        "../../formats/src",
    ] {
        if std::path::Path::new(path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    println!("cargo::rerun-if-changed=build.rs");
    let described = Command::new("git")
        .args(["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"])
        .output();
    // Built from a package, or without git: nobody knows.
    let commit = described.ok().filter(|output| output.status.success());
    let commit = commit.and_then(|output| String::from_utf8(output.stdout).ok());
    println!("cargo::rustc-env=POCKETNERF_COMMIT={}", commit.unwrap_or_default().trim());
}
