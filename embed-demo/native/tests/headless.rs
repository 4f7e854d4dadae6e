//! Pictures without a window, and what is said about misuse.

mod common;

use common::{STILL_LIFE, picture, read_png, repository, viewer};
use pocketnerf_core::space::Contracted;
use pocketnerf_core::{Camera, Model, Space};
use pocketnerf_formats::Precision;
use pocketnerf_view::view::View;

const GOLDEN: &str = "tests/golden/hash-grid-f16.pnerf";

#[test]
fn pictures_are_those_of_the_rust_api() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    for model in ["embed-demo/still-life.pnerf", GOLDEN] {
        let bytes = std::fs::read(repository(model)).unwrap();
        let file = pocketnerf_formats::open_verified(&bytes).unwrap();
        for [width, height] in [[96, 96], [201, 75]] {
            let size = format!("{width}x{height}");
            let mut command = viewer();
            command.arg(repository(model)).args(["--headless", "--size", &size, "--threads", "2"]);
            let output = command.arg("--out").arg(&path).output().unwrap();
            assert!(output.status.success(), "{output:?}");
            let camera = View::new(&file).camera(width, height);
            let own = file.about.camera.unwrap();
            if width == height && own.width == own.height {
                let pose = own.camera_to_world;
                assert_eq!(camera, Camera::from_fov_x(width, height, own.fov_x, pose));
            }
            let quality = file.about.quality.unwrap_or(0.5);
            let (found, rgb) = read_png(&path);
            assert_eq!(found, [width, height]);
            assert!(rgb == picture(&file, &camera, quality), "{model} {size}");
        }
    }
}

#[test]
fn a_packed_file_shows_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let [model, path] = ["packed.pnerf", "picture.png"].map(|name| folder.path().join(name));
    std::fs::write(&model, pocketnerf_formats::pack(STILL_LIFE).unwrap()).unwrap();
    let mut command = viewer();
    command.arg(&model).args(["--headless", "--size", "60x50", "--quality", "1", "--out"]);
    let output = command.arg(&path).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    assert!(read_png(&path).1 == picture(&file, &View::new(&file).camera(60, 50), 1.0));
}

#[test]
fn an_orbit_begins_with_the_view() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a/b");
    let mut command = viewer();
    command.args(["--orbit", "3", "--size", "40x30", "--quality", "1", "--out"]).arg(&out);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert_eq!(
        String::from_utf8(output.stdout).unwrap(),
        format!("{}: 3 pictures\n", out.display())
    );
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let views = View::new(&file).orbit(3);
    for (i, view) in views.iter().enumerate() {
        let (_, rgb) = read_png(out.join(format!("{i:03}.png")));
        assert!(rgb == picture(&file, &view.camera(40, 30), 1.0), "{i}");
    }
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 3);
}

#[test]
fn modes_show_different_things() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen = Vec::new();
    for mode in ["colour", "depth", "normals", "occupancy"] {
        let path = folder.path().join(mode);
        let mut command = viewer();
        let command = command.args(["--mode", mode, "--size", "64x48", "--out"]).arg(&path);
        assert!(command.output().unwrap().status.success());
        let picture = std::fs::read(path).unwrap();
        assert!(!seen.contains(&picture), "{mode}");
        seen.push(picture);
    }
    // A forward-facing capture has all but normals, and so has a scene without an end.
    let golden = std::fs::read(repository(GOLDEN)).unwrap();
    let golden = pocketnerf_formats::open(&golden).unwrap();
    let space = Space::Contracted(Contracted { center: [0.0; 3], radius: 4.0 });
    let model = Model { space, ..golden.model };
    let contracted = folder.path().join("contracted.pnerf");
    let bytes = pocketnerf_formats::write(&model, &golden.about, Precision::F16).unwrap();
    std::fs::write(&contracted, bytes).unwrap();
    for file in [repository("tests/golden/ndc-f16.pnerf"), contracted] {
        let mut seen = Vec::new();
        for (mode, is_there) in
            [("colour", true), ("depth", true), ("normals", false), ("occupancy", true)]
        {
            let path = folder.path().join("another.png");
            let mut command = viewer();
            command.arg(&file);
            let command = command.args(["--mode", mode, "--size", "32x24", "--out"]).arg(&path);
            let output = command.output().unwrap();
            assert_eq!(output.status.success(), is_there, "{output:?}");
            assert_eq!(path.exists(), is_there);
            if is_there {
                let (_, rgb) = read_png(&path);
                assert!(!seen.contains(&rgb), "{mode}");
                assert!(rgb.as_chunks::<3>().0.iter().any(|p| *p != rgb[..3]), "{mode}");
                seen.push(rgb);
                std::fs::remove_file(path).unwrap();
            }
        }
    }
}

#[test]
fn text_for_a_terminal() {
    let output = viewer().args(["--terminal", "--width", "7"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let camera = View::new(&file).camera(7, 7);
    let rgb = picture(&file, &camera, file.about.quality.unwrap_or(0.5));
    let codes = |which: u8, x: usize, y: usize| {
        let p = &rgb[3 * (7 * y + x)..][..3];
        format!("\x1b[{which};2;{};{};{}m", p[0], p[1], p[2])
    };
    let mut expected = String::new();
    for y in [0, 2, 4, 6] {
        for x in 0..7 {
            let below = if y < 6 { codes(48, x, y + 1) } else { String::new() };
            expected += &format!("{}{below}▀", codes(38, x, y));
        }
        expected += "\x1b[0m\n";
    }
    assert_eq!(String::from_utf8(output.stdout).unwrap(), expected);
}

/// Runs the program and expects this status and a line that begins and ends like this.
fn refuses(arguments: &[&str], status: i32, begin: &str, end: &str) {
    let output = viewer().args(arguments).output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {text}");
    let first = text.lines().next().unwrap_or_default();
    assert!(first.starts_with(begin) && first.ends_with(end), "{arguments:?}: {text}");
    assert!(output.stdout.is_empty() && (status == 2 || text.lines().count() == 1), "{text}");
}

#[test]
fn misuse_is_told_in_a_line() {
    let error = |text: &str| format!("pocketnerf-view: {text}");
    refuses(&["nowhere.pnerf"], 1, &error("nowhere.pnerf: cannot be read: "), "give a .pnerf file");
    let no_model = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let begin = error(&format!("{no_model}: not a .pnerf file: "));
    refuses(&[no_model], 1, &begin, "give a model that `pocketnerf info` can read");
    refuses(
        &[],
        1,
        &error("no window: "),
        "or without one --headless --out FILE.png, or --terminal",
    );
    let nowhere = "/nowhere/at/all.png";
    let begin = error("/nowhere/at/all.png: cannot be written: ");
    refuses(&["--size", "8x8", "--out", nowhere], 1, &begin, "give another place");
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("script");
    std::fs::write(&script, "wait 1\njump").unwrap();
    let script = script.to_str().unwrap();
    let begin = error(&format!("{script}: line 2: \"jump\", expected wait, "));
    refuses(&["--script", script], 1, &begin, "as in --help");
    for (arguments, begin) in [
        (&["--quality", "1.5"][..], "error: invalid value '1.5' for '--quality <Q>'"),
        (&["--size", "0x5"], "error: invalid value '0x5' for '--size <WxH>'"),
        (&["--fps", "0"], "error: invalid value '0' for '--fps <F>'"),
        (&["--orbit", "0"], "error: invalid value '0' for '--orbit <N>'"),
        (&["--terminal", "--out", "x"], "error: the argument '--terminal' cannot be used with"),
        (&["--width", "5"], "error: the following required arguments were not provided"),
        (&["--jump"], "error: unexpected argument '--jump'"),
    ] {
        refuses(arguments, 2, begin, "");
    }
}

#[test]
fn damaged_models_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.pnerf");
    let golden = std::fs::read(repository(GOLDEN)).unwrap();
    for at in [0, 9, 40, golden.len() / 2, golden.len() - 1] {
        let mut bytes = golden.clone();
        bytes[at] ^= 0x55;
        std::fs::write(&path, &bytes).unwrap();
        refuses(
            &[path.to_str().unwrap(), "--out", "/nowhere/x.png"],
            1,
            "pocketnerf-view: ",
            "read",
        );
    }
    std::fs::write(&path, &golden[..golden.len() / 2]).unwrap();
    refuses(&[path.to_str().unwrap()], 1, "pocketnerf-view: ", "read");
}
