//! Programs in C and C++: they compile without a warning, run clean under sanitizers, show the
//! picture that the Rust crates show, and find the installed library.
//!
//! What is missing on a machine is told and left out, unless `POCKETNERF_REQUIRE_TOOLS` is
//! set. `POCKETNERF_C_LIBRARY` names another static library to link, such as one that is
//! itself built for a sanitizer.

mod cpp;
mod csharp;
mod installed;

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Model, RenderOptions, SimdLevel, Tuning, render_tile};
use pocketnerf_formats::open;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const SANITIZERS: [&str; 3] =
    ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"];
const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];
const LIBRARIES: [&str; 3] = ["-lpthread", "-ldl", "-lm"];

/// Whether such a program answers.
fn there_is(program: &str, arguments: &[&str]) -> bool {
    let found = Command::new(program).args(arguments).output().is_ok_and(|o| o.status.success());
    if !found {
        let text = format!("{program} {arguments:?}: no answer; what needs it is not tested");
        assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "{text}");
        eprintln!("{text}");
    }
    found
}

fn there_is_png() -> bool {
    there_is("pkg-config", &["--exists", "libpng"])
}

fn path(relative: &str) -> PathBuf {
    Path::new(ROOT).join(relative)
}

/// The static library that cargo has built beside this test.
fn library() -> PathBuf {
    if let Some(path) = std::env::var_os("POCKETNERF_C_LIBRARY") {
        return path.into();
    }
    std::env::current_exe().unwrap().with_file_name("libpocketnerf_c.a")
}

fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{command:?}\n{}\n{out}\n{err}", output.status);
    output
}

/// Compiles a source file of ours, and links it with the static library; `options` stand
/// after both.
fn compile(compiler: &str, source: &str, options: &[&str], out: &Path) {
    let mut command = Command::new(compiler);
    command.args(STRICT).args(SANITIZERS).arg("-I").arg(path("include"));
    run(command.arg(path(source)).arg(library()).args(options).args(LIBRARIES).arg("-o").arg(out));
}

/// The view that a file begins with, as a Rust program shows it.
fn picture(model: &Model<'_>, camera: &pocketnerf_core::Camera) -> Vec<u8> {
    let options = RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST);
    let mut scratch = vec![0.0; options.scratch_len()];
    let mut picture = vec![0; 4 * (camera.width * camera.height) as usize];
    for tile in Tiles::new(camera.width, camera.height) {
        let mut rgba = vec![0.0; 4 * tile.pixels()];
        render_tile(model, camera, tile, &options, &mut scratch, &mut rgba, None).unwrap();
        let width = tile.width as usize;
        for (y, row) in (tile.y..).zip(rgba.as_chunks::<4>().0.chunks(width)) {
            let at = 4 * (y * camera.width + tile.x) as usize;
            let row = row.iter().flat_map(|rgba| {
                let [r, g, b] = model.display.rgb8(*rgba);
                [r, g, b, 255]
            });
            picture[at..at + 4 * width].iter_mut().zip(row).for_each(|(to, byte)| *to = byte);
        }
    }
    picture
}

/// Width, height and RGBA of a PNG.
fn decoded(path: &Path) -> ((u32, u32), Vec<u8>) {
    let mut decoder = png::Decoder::new(BufReader::new(File::open(path).unwrap()));
    decoder.set_transformations(png::Transformations::ALPHA);
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    ((info.width, info.height), bytes)
}

#[test]
fn examples_show_what_a_rust_program_shows() {
    if !there_is("gcc", &["--version"]) || !there_is_png() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let model = path("../still-life.pnerf");
    let bytes = std::fs::read(&model).unwrap();
    let file = open(&bytes).unwrap();
    let camera = file.about.camera.unwrap().camera();
    let expected = picture(&file.model, &camera);
    for (compiler, source, standard) in
        [("gcc", "examples/picture.c", "-std=c99"), ("g++", "examples/picture.cpp", "-std=c++17")]
    {
        if !there_is(compiler, &["--version"]) {
            continue;
        }
        let (program, png) = (folder.path().join("program"), folder.path().join("picture.png"));
        compile(compiler, source, &[standard, "-lpng"], &program);
        run(Command::new(&program).args([&model, &png]));
        let (size, found) = decoded(&png);
        assert_eq!(size, (camera.width, camera.height));
        assert!(found == expected, "{source}");

        // What is wrong is one line.
        let wrong = Command::new(&program).arg(path("Cargo.toml")).arg(&png).output().unwrap();
        let line = String::from_utf8(wrong.stderr).unwrap();
        assert_eq!((wrong.status.code(), line.lines().count()), (Some(1), 1), "{line}");
        assert!(line.contains("Cargo.toml: not a .pnerf file"), "{line}");
    }
}

#[test]
fn misuse_is_refused_and_damaged_files_are_survived() {
    if !there_is("gcc", &["--version"]) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let golden = |name: &str| path("../../tests/golden").join(format!("{name}.pnerf"));
    let program = folder.path().join("program");
    let build = |source: &str| compile("gcc", source, &["-std=c99"], &program);
    build("tests/c/misuse.c");
    run(Command::new(&program).args([golden("hash-grid-f16"), golden("unknown-critical")]));
    build("tests/c/mutated.c");
    let kinds = [
        "hash-grid-f16",
        "per-sample-f16",
        "nerf-f16",
        "ndc-f16",
        "detail-f16",
        "hash-grid-i8",
        "plenoxels-i8",
        "planes-i8",
        "derf-f16",
    ];
    let said = run(Command::new(&program).arg("10000").args(kinds.map(golden)));
    println!("{}", String::from_utf8_lossy(&said.stdout));
}
