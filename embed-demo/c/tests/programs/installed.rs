//! The library as `install` leaves it, in a folder that was moved since.

use std::path::Path;
use std::process::Command;

use crate::{path, run, there_is, there_is_png};

/// What pkg-config says of the library in this folder.
pub(crate) fn flags(prefix: &Path, packages: &[&str]) -> Vec<String> {
    let mut command = Command::new("pkg-config");
    command.args(["--cflags", "--libs"]).args(packages);
    let said = run(command.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"))).stdout;
    String::from_utf8(said).unwrap().split_whitespace().map(str::to_owned).collect()
}

#[test]
fn an_installed_library_is_found() {
    let all = ["gcc", "g++", "cmake", "readelf"];
    if !all.iter().all(|program| there_is(program, &["--version"])) || !there_is_png() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [prefix, moved] = ["prefix", "moved"].map(|name| folder.path().join(name));
    let nothing = Command::new(path("install")).arg(&prefix).arg(folder.path()).output().unwrap();
    let said = String::from_utf8(nothing.stderr).unwrap();
    assert!(said.ends_with("/libpocketnerf_c.a: not there, expected the C library\n"), "{said}");
    assert!(nothing.status.code() == Some(1) && !prefix.exists() && said.lines().count() == 1);
    let built = std::env::current_exe().unwrap().with_file_name("");
    run(Command::new(path("install")).arg(&prefix).arg(built));
    std::fs::rename(&prefix, &moved).unwrap();
    let prefix = moved;
    let model = path("../still-life.pnerf");
    let pictures =
        ["c", "cmake-c", "cmake-cpp"].map(|name| folder.path().join(name).with_extension("png"));

    let program = folder.path().join("program");
    let mut command = Command::new("gcc");
    command.arg("-std=c99").arg(path("examples/picture.c"));
    run(command.args(flags(&prefix, &["pocketnerf", "libpng"])).arg("-o").arg(&program));
    let libraries = prefix.join("lib");
    run(Command::new(&program).args([&model, &pictures[0]]).env("LD_LIBRARY_PATH", &libraries));

    let build = folder.path().join("build");
    let mut command = Command::new("cmake");
    command.arg("-S").arg(path("tests/cmake")).arg("-B").arg(&build);
    run(command.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display())));
    run(Command::new("cmake").arg("--build").arg(&build));
    for (name, picture) in ["picture", "wrapped"].iter().zip(&pictures[1..]) {
        run(Command::new(build.join(name)).args([&model, picture]));
    }
    let [first, others @ ..] = pictures.map(|path| std::fs::read(path).unwrap());
    assert!(others.iter().all(|other| *other == first));

    // Programs ask for the major number that they were made for.
    let needs = format!("Shared library: [libpocketnerf_c.so.{}]", pocketnerf_c::ABI_VERSION >> 16);
    for program in [program, build.join("wrapped")] {
        let said = run(Command::new("readelf").arg("--dynamic").arg(&program)).stdout;
        let said = String::from_utf8(said).unwrap();
        assert!(said.contains(&needs), "{}\n{said}", program.display());
    }
}
