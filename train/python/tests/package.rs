//! The Python package, with the compiled part that cargo has built beside this test: pytest runs
//! its tests.
//!
//! `POCKETNERF_PYTHON` names the Python, which needs what `tests/requirements.txt` lists; without it
//! there is no test, unless `POCKETNERF_REQUIRE_TOOLS` is set.

use std::path::{Path, PathBuf};
use std::process::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Copies a folder and what is in it.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &to),
            false => drop(std::fs::copy(entry.path(), to).unwrap()),
        }
    }
}

#[test]
fn python() {
    let Some(python) = std::env::var_os("POCKETNERF_PYTHON") else {
        let text = "POCKETNERF_PYTHON: not set; the Python package is not tested";
        assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "{text}");
        eprintln!("{text}");
        return;
    };
    let site = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("python");
    let package = site.join("pocketnerf");
    if package.exists() {
        std::fs::remove_dir_all(&package).unwrap();
    }
    copy(&Path::new(ROOT).join("package/pocketnerf"), &package);
    let library = std::env::current_exe().unwrap().with_file_name("lib_native.so");
    std::fs::copy(&library, package.join("_native.abi3.so")).unwrap();
    let mut pytest = Command::new(python);
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations=10"]);
    // Many tests wait, or keep one core busy.
    pytest.args(["--numprocesses=auto", "--dist=loadfile", "--rootdir"]);
    let tests = Path::new(ROOT).join("tests");
    let status = pytest
        .args([tests.as_os_str(), tests.as_os_str()])
        .env("PYTHONPATH", &site)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        // A folder that hides no package.
        .current_dir(&site)
        .status();
    assert!(status.unwrap().success());
}
