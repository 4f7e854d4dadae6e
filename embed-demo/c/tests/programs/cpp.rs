//! The wrapper for C++ gives what C gives, and says what is wrong.

use std::process::Command;

use crate::{compile, path, run, there_is};

/// The first is run; the others are only to be without a warning. What throws is run as an example.
const WAYS: [&[&str]; 3] = [
    &["-std=c++17", "-fno-exceptions", "-fno-rtti", "-fno-sanitize=vptr"],
    &["-std=c++17", "-DPOCKETNERF_EXCEPTIONS", "-fsyntax-only"],
    &["-std=c++20", "-Wshadow", "-Wconversion", "-fsyntax-only"],
];

#[test]
fn the_wrapper_gives_what_c_gives() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("program");
    let models = ["../still-life.pnerf", "../../tests/golden/photographs-f16.pnerf"].map(path);
    let has_clang = Command::new("clang++").arg("--version").output().is_ok();
    for compiler in ["g++", "clang++"] {
        if (compiler == "clang++" && !has_clang) || !there_is(compiler, &["--version"]) {
            continue;
        }
        for way in WAYS {
            // Nothing is linked where nothing is made.
            let way = [way, &["-Wno-unused-command-line-argument"]].concat();
            compile(compiler, "tests/cpp/wrapper.cpp", &way, &program);
        }
        run(Command::new(&program).args(&models));
        // The value of a failure ends a program, and says why.
        let ended = Command::new(&program).args(&models).arg("/nowhere").output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(!ended.status.success(), "{said}");
        assert!(said.starts_with("pocketnerf: /nowhere: No such file"), "{said}");
    }
}
