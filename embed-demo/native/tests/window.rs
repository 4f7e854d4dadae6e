//! The window itself, on a display of its own, with events of the X server.

mod common;
#[path = "common/x11.rs"]
mod x11;

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

use common::{STILL_LIFE, picture, read_png, viewer};
use pocketnerf_core::Camera;
use pocketnerf_view::view::View;
use x11::{Display, Program, wait_for};

const SIZE: [u16; 2] = [200, 160];
const RIGHT: u32 = 0xff53;
const ESCAPE: u32 = 0xff1b;

fn start(display: &Display, arguments: &[&str], screenshots: &Path) -> Program {
    let mut command: Command = viewer();
    // Whatever the display says about its size in millimetres.
    command.env("DISPLAY", &display.name).env("WINIT_X11_SCALE_FACTOR", "1");
    command.args(["--size", "200x160", "--no-overlay", "--screenshots"]).arg(screenshots);
    Program(command.args(arguments).stdout(Stdio::piped()).spawn().unwrap())
}

/// What a program said, when it has ended well.
fn ended(mut program: Program) -> String {
    let status = wait_for("the end", || program.0.try_wait().unwrap());
    assert!(status.success(), "{status}");
    let mut said = String::new();
    program.0.stdout.take().unwrap().read_to_string(&mut said).unwrap();
    said
}

#[test]
fn shows_the_picture_of_the_rust_api() {
    let Some(display) = Display::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let program = start(&display, &[], folder.path());
    let window = display.window(SIZE);
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let quality = file.about.quality.unwrap_or(0.5);
    let expected = |camera: &Camera| picture(&file, camera, quality);
    let shows = |what: &str, rgb: &[u8]| {
        wait_for(what, || (display.seen(window) == rgb).then_some(()));
    };
    let [width, height] = SIZE.map(u32::from);
    let mut view = View::new(&file);
    shows("the first picture", &expected(&view.camera(width, height)));

    // How many steps a wheel without axes makes is winit's business.
    let first = display.seen(window);
    display.point([100, 80]);
    display.press(4);
    display.release(4);
    wait_for("a wheel", || (display.seen(window) != first).then_some(()));
    display.key(u32::from(b'r'));
    shows("the first picture again", &first);

    // A key turns by five degrees, another one goes nearer.
    display.key(RIGHT);
    view.turn(std::f32::consts::PI / 36.0, 0.0);
    shows("a turn", &expected(&view.camera(width, height)));
    display.key(u32::from(b'='));
    view.approach(pocketnerf_view::window::input::nearer(1.0));
    let near = expected(&view.camera(width, height));
    shows("a step nearer", &near);

    display.key(u32::from(b's'));
    let path = folder.path().join("still-life-001.png");
    wait_for("the screenshot", || path.exists().then_some(()));
    assert!(read_png(&path) == ([width, height], near.clone()));

    // A drag shows other pictures at once, and in the end the one where it went.
    display.press(1);
    display.point([130, 90]);
    wait_for("a moving picture", || (display.seen(window) != near).then_some(()));
    display.release(1);
    view.drag([30.0, 10.0], height);
    shows("a drag", &expected(&view.camera(width, height)));
    display.press(3);
    display.point([120, 70]);
    display.release(3);
    view.pull([-10.0, -20.0], [width, height]);
    let pulled = expected(&view.camera(width, height));
    shows("a pull", &pulled);

    // Depth is something else, and colour is the same again.
    display.key(u32::from(b'2'));
    wait_for("depth", || (display.seen(window) != pulled).then_some(()));
    display.key(u32::from(b'1'));
    shows("colour again", &pulled);
    // Figures cover a corner.
    display.key(u32::from(b'h'));
    wait_for("figures", || (display.seen(window) != pulled).then_some(()));
    display.key(u32::from(b'h'));
    shows("no figures", &pulled);

    display.resize(window, [1, 1]);
    display.window([1, 1]);
    display.resize(window, [90, 120]);
    display.window([90, 120]);
    shows("another size", &expected(&view.camera(90, 120)));
    display.key(u32::from(b'r'));
    shows("the first view", &expected(&View::new(&file).camera(90, 120)));

    display.key(ESCAPE);
    assert_eq!(ended(program), format!("{}\n", path.display()));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn plays_a_script_and_counts() {
    let Some(display) = Display::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("script");
    std::fs::write(&script, "rest\ndrag left 60 0 300\nrest\nkey 3\nrest\nkey s\n").unwrap();
    let arguments = ["--script", script.to_str().unwrap()];
    let said = ended(start(&display, &arguments, folder.path()));
    let lines: Vec<&str> = said.lines().collect();
    let path = folder.path().join("still-life-001.png");
    assert_eq!((lines.len(), lines[0]), (2, path.to_str().unwrap()));
    let figures: serde_json::Value = serde_json::from_str(lines[1]).unwrap();
    assert!(figures["frames"].as_u64() > Some(0), "{figures}");
    assert!(figures["rests"].as_u64() >= Some(3), "{figures}");
    for key in ["fps", "frame_ms", "frame_ms_p95", "frame_ms_max", "scale", "rest_ms"] {
        assert!(figures[key].as_f64() > Some(0.0), "{key}: {figures}");
    }
    let (size, normals) = read_png(path);
    assert_eq!(size, SIZE.map(u32::from));
    let background = [255; 3];
    assert!(normals.as_chunks::<3>().0.iter().any(|pixel| *pixel != background));
}
