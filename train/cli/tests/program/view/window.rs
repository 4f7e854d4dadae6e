//! A window on a run, with events of the X server.

use pocketnerf_train::picture::image_file;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Stdio};

use super::{MODEL, STEPS, alone};
use crate::place::{Place, TRAIN};

#[path = "../../../../../embed-demo/native/tests/common/x11.rs"]
mod x11;

use x11::{Display, Program, wait_for};

const ESCAPE: u32 = 0xff1b;
const H: u32 = 0x68;
const S: u32 = 0x73;

fn start(place: &Place, display: &Display, options: &str) -> Program {
    let mut command = place.command(options);
    command.env_remove("WAYLAND_DISPLAY").env("DISPLAY", &display.name);
    command.env("WINIT_X11_SCALE_FACTOR", "1");
    Program(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
}

fn read(stream: &mut Option<impl Read>) -> String {
    let mut said = String::new();
    stream.take().unwrap().read_to_string(&mut said).unwrap();
    said
}

/// Different colours of a picture.
fn colors(rgb: &[u8]) -> usize {
    let mut colors = rgb.as_chunks::<3>().0.to_vec();
    colors.sort_unstable();
    colors.dedup();
    colors.len()
}

#[test]
fn a_scene_appears_turns_and_is_learnt_without_its_window() {
    let Some(display) = Display::open() else { return };
    let place = Place::new();
    let train = TRAIN.replace("--quiet ", "");
    let mut program =
        start(&place, &display, &format!("{train} --steps {STEPS} --out seen.pnerf --view"));
    // As large as the photographs.
    let window = display.window([25, 25]);
    display.key(H);
    let first =
        wait_for("a picture", || Some(display.seen(window)).filter(|picture| colors(picture) > 8));
    let later = wait_for("another model", || {
        Some(display.seen(window)).filter(|picture| *picture != first)
    });
    display.point([5, 12]);
    display.press(1);
    display.point([20, 12]);
    display.release(1);
    wait_for("a turn", || (display.seen(window) != later).then_some(()));
    display.key(ESCAPE);
    let status = wait_for("the end", || program.0.try_wait().unwrap());
    let said = read(&mut program.0.stderr);
    assert!(status.success(), "{said}");
    assert_eq!(said.matches("the window is closed; training goes on\n").count(), 1, "{said}");
    let result: serde_json::Value = serde_json::from_str(&read(&mut program.0.stdout)).unwrap();
    assert_eq!(result["steps"], STEPS);
    assert!(place.bytes("seen.pnerf") == alone());
}

/// What is printed when training is done, while the window is still open.
fn first_line(program: &mut Child) -> String {
    let mut line = String::new();
    BufReader::new(program.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    line
}

#[test]
fn the_finished_model_stays_until_the_window_is_closed() {
    let Some(display) = Display::open() else { return };
    let place = Place::new();
    let mut program =
        start(&place, &display, &format!("{TRAIN} --steps 100 --out seen.pnerf --view"));
    let window = display.window([25, 25]);
    display.key(H);
    let line = first_line(&mut program.0);
    assert!(line.starts_with('{') && line.contains("\"steps\":100"), "{line}");
    let path = place.path("whole.png");
    let shown = place.run("view seen.pnerf --headless --quality 0.5 --out whole.png");
    assert!(shown.status.success());
    let whole = image_file::open(path).unwrap().to_rgb8().into_raw();
    wait_for("the finished model", || (display.seen(window) == whole).then_some(()));
    assert!(program.0.try_wait().unwrap().is_none());
    display.key(S);
    let screenshot = wait_for("a screenshot", || image_file::open(place.path("seen-001.png")).ok());
    assert_eq!(screenshot.to_rgb8().into_raw(), whole);
    display.key(ESCAPE);
    assert!(wait_for("the end", || program.0.try_wait().unwrap()).success());
    // Standard output has the result alone.
    assert!(read(&mut program.0.stderr).contains("seen-001.png\n"));
    assert_eq!(read(&mut program.0.stdout), "");
}

/// What the window saves is what `render` makes, of a model whose coordinates are not the dataset's:
/// the path that is in the file, and the one through its keyframes alone.
#[test]
fn a_path_that_the_window_saves_is_rendered_as_it_was_shown() {
    let Some(display) = Display::open() else { return };
    let place = Place::new();
    let bytes = std::fs::read(MODEL).unwrap();
    let file = pocketnerf_formats::open(&bytes).unwrap();
    let scene = pocketnerf_formats::Scene {
        scale: 2.0,
        rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [10.0, 20.0, 30.0],
        ..file.about.scene
    };
    let about = pocketnerf_formats::About { scene, ..file.about };
    let turned =
        pocketnerf_formats::write(&file.model, &about, pocketnerf_formats::Precision::I8).unwrap();
    std::fs::write(place.path("turned.pnerf"), turned).unwrap();
    let script =
        "key k\ndrag left 15 4 8\nkey k\nwheel 3\ndrag right 5 -5 8\nkey k\nrest\nkey s\nkey w\n";
    std::fs::write(place.path("script"), script).unwrap();
    let mut program = start(
        &place,
        &display,
        "view turned.pnerf --size 48x40 --no-overlay --quality 0.5 --script script",
    );
    let status = wait_for("the end", || program.0.try_wait().unwrap());
    let said = read(&mut program.0.stdout);
    assert!(status.success() && said.contains("camera_path.json: saved, 3 keyframes"), "{said}");

    let path = |name: &str| {
        let wanted = pocketnerf_train::cameras::Wanted::default();
        pocketnerf_train::cameras::camera_path(&place.path(name), wanted).unwrap()
    };
    let saved = path("camera_path.json");
    let mut alone: serde_json::Value =
        serde_json::from_slice(&place.bytes("camera_path.json")).unwrap();
    alone.as_object_mut().unwrap().remove("camera_path");
    std::fs::write(place.path("alone.json"), alone.to_string()).unwrap();
    let through = path("alone.json");
    assert_eq!((saved.cameras.len(), saved.fps), (120, Some(30.0)));
    assert_eq!(through.cameras.len(), 120);
    for (a, b) in saved.cameras.iter().zip(&through.cameras) {
        let pairs = a.camera_to_world.iter().zip(&b.camera_to_world);
        assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-4), "{a:?} {b:?}");
        assert!((a.focal[0] - b.focal[0]).abs() < 1e-3 && a.width == 48 && a.height == 40);
    }

    let options = "--antialias off --quality 0.5 --out frames";
    place.ok(&format!("render turned.pnerf --camera-path camera_path.json {options}"));
    let open = |name: &str| image::open(place.path(name)).unwrap().to_rgb8().into_raw();
    let (first, last) = (open("frames/000.png"), open("frames/119.png"));
    let off = |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(off(&last, &open("turned-001.png")) < 12);
    assert!(off(&last, &first) > 1000);
    place.ok("view turned.pnerf --headless --size 48x40 --quality 0.5 --out own.png");
    assert!(off(&first, &open("own.png")) < 12);
}
