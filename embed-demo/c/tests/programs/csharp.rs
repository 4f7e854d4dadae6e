//! The wrapper for C#, on Mono: the C library's bytes, and exceptions with one line. The view for
//! Unity is compiled and run against the few types of Unity's that it uses.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use pocketnerf_core::Camera;
use pocketnerf_formats::open;

use crate::{path, picture, run, there_is};

const WRAPPER: [&str; 3] = ["Pocketnerf.cs", "Types.cs", "Native.cs"];

fn compile(sources: &[&str], out: &Path) {
    let sources = WRAPPER.iter().chain(sources).map(|name| path("../csharp").join(name));
    let mut out_as = std::ffi::OsString::from("-out:");
    out_as.push(out);
    run(Command::new("mcs").arg("-warnaserror").arg(out_as).args(sources));
}

/// With the shared library that cargo has built beside this test.
fn mono(program: &Path, arguments: &[PathBuf]) -> Command {
    let libraries = std::env::current_exe().unwrap().with_file_name("");
    let mut command = Command::new("mono");
    command.arg(program).args(arguments).env("LD_LIBRARY_PATH", libraries);
    command
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

#[test]
fn csharp_shows_what_a_rust_program_shows() {
    if !["mcs", "mono"].iter().all(|program| there_is(program, &["--version"])) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [program, out] = ["Picture.exe", "picture.ppm"].map(|name| folder.path().join(name));
    compile(&["Picture.cs"], &program);
    let model = path("../still-life.pnerf");
    run(&mut mono(&program, &[model.clone(), out.clone()]));
    let bytes = std::fs::read(&model).unwrap();
    let file = open(&bytes).unwrap();
    let camera: Camera = file.about.camera.unwrap().camera();
    let mut expected = format!("P6\n{} {}\n255\n", camera.width, camera.height).into_bytes();
    for rgba in picture(&file.model, &camera).as_chunks::<4>().0 {
        expected.extend_from_slice(&rgba[..3]);
    }
    assert!(std::fs::read(&out).unwrap() == expected);

    let wrong = mono(&program, &[path("Cargo.toml"), out]).output().unwrap();
    let line = text(wrong.stderr);
    assert_eq!((wrong.status.code(), line.lines().count()), (Some(1), 1), "{line}");
    assert!(line.contains("Cargo.toml: not a .pnerf file"), "{line}");
}

#[test]
fn csharp_gives_what_c_gives() {
    if !["mcs", "mono"].iter().all(|program| there_is(program, &["--version"])) {
        return;
    }
    let native = std::fs::read_to_string(path("../csharp/Native.cs")).unwrap();
    let version = format!("const uint AbiVersion = {};", pocketnerf_c::ABI_VERSION);
    assert!(native.contains(&version), "{version}");

    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("Check.exe");
    compile(&["Unity/PocketnerfView.cs", "tests/UnityStubs.cs", "tests/Check.cs"], &program);
    let models = ["../still-life.pnerf", "../../tests/golden/photographs-f16.pnerf"].map(path);
    let Output { stdout, .. } = run(&mut mono(&program, &models));
    assert_eq!(text(stdout), facts(&models[0]));
}

/// As `Check.cs` prints them, from the Rust side of the C interface.
fn facts(model: &Path) -> String {
    use std::ptr::null_mut;
    let bytes = std::fs::read(model).unwrap();
    let mut opened = null_mut();
    // SAFETY: all pointers are those of variables here.
    let (info, camera) = unsafe {
        let (mut info, mut camera) =
            (std::mem::zeroed::<pocketnerf_c::Info>(), std::mem::zeroed::<pocketnerf_c::Camera>());
        let (data, length) = (bytes.as_ptr().cast(), bytes.len());
        let status = pocketnerf_c::pnrf_open_bytes(data, length, 0, &raw mut opened, null_mut());
        assert_eq!(status, pocketnerf_c::Status::Ok);
        pocketnerf_c::pnrf_info(opened, &raw mut info, null_mut());
        pocketnerf_c::pnrf_default_camera(opened, 40, 30, &raw mut camera, null_mut());
        pocketnerf_c::pnrf_close(opened);
        (info, camera)
    };
    let flag = |is: u32| if is == 1 { "True" } else { "False" };
    let [queries, own, linear] = [info.has_queries, info.has_camera, info.is_linear].map(flag);
    let whole = format!(
        "{} {} {} {queries} {own} {linear} {} {}",
        info.bytes, info.parameters, info.table_bytes, camera.width, camera.height
    );
    let m = camera.camera_to_world;
    let numbers = [
        info.occupancy,
        info.center[2],
        info.radius,
        info.box_min[0],
        info.box_max[2],
        info.scale,
        info.rotation[8],
        info.translation[2],
        info.step,
        info.background[0],
        info.quality,
        camera.focal[1],
        camera.center[0],
        m[4],
        m[9],
        m[2],
        m[3],
        m[11],
    ];
    let bits: Vec<_> = numbers.iter().map(|v| format!("{:08x}", v.to_bits())).collect();
    format!("{whole}\n{}\n", bits.join(" "))
}
