//! The window itself, on a display of its own, with events of the X server.

mod common;
#[path = "common/x11.rs"]
mod x11;

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

use common::{STILL_LIFE, picture, read_png, viewer};
use pocketnerf_core::Camera;
use pocketnerf_core::camera::{Keyframe, KeyframePath};
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

/// Keyframes are what was shown, the file has the path through them, and any input ends it where it
/// is.
#[test]
fn keyframes_become_a_camera_path() {
    let Some(display) = Display::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let [script, path] = ["script", "path.json"].map(|name| folder.path().join(name));
    let keys =
        "key k\ndrag left 60 0 8\nkey k\nkey w\nkey p\nwait 200\nkey k\nrest\nkey s\nkey w\n";
    std::fs::write(&script, keys).unwrap();
    let arguments = ["--script", script.to_str().unwrap(), "--save-path", path.to_str().unwrap()];
    let said = ended(start(&display, &arguments, folder.path()));
    let picture_path = folder.path().join("still-life-001.png");
    let expected = [
        format!("{}: saved, 2 keyframes, 2 seconds", path.display()),
        picture_path.display().to_string(),
        format!("{}: saved, 3 keyframes, 4 seconds", path.display()),
    ];
    assert_eq!(said.lines().take(3).collect::<Vec<_>>(), expected);

    let saved: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    assert_eq!((&saved["render_width"], &saved["render_height"]), (&200.into(), &160.into()));
    let numbers = |pose: &serde_json::Value| -> Vec<f32> {
        pose.as_array().unwrap().iter().map(|x| x.as_f64().unwrap() as f32).collect()
    };
    let keyframes = saved["keyframes"].as_array().unwrap();
    let poses: Vec<_> = keyframes.iter().map(|keyframe| numbers(&keyframe["matrix"])).collect();
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let mut view = View::new(&file);
    let near = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
    let [width, height] = SIZE.map(u32::from);
    let shown = |view: &View| file.about.scene.camera_to_dataset(&view.camera(width, height));
    assert!(near(&poses[0], &shown(&view).camera_to_world), "{:?}", poses[0]);
    view.drag([60.0, 0.0], height);
    assert!(near(&poses[1], &shown(&view).camera_to_world), "{:?}", poses[1]);
    let fov = 2.0 * (80.0 / f64::from(shown(&view).focal[1])).atan().to_degrees();
    assert!((keyframes[1]["fov"].as_f64().unwrap() - fov).abs() < 1e-4, "{saved}");

    // The third one is a picture of the path through the first two, where it was ended.
    let keyframe = |pose: &Vec<f32>| Keyframe {
        pose: pose[..].try_into().unwrap(),
        fov_y: fov,
        seconds: Keyframe::SECONDS,
    };
    let two = [keyframe(&poses[0]), keyframe(&poses[1])];
    let path = KeyframePath { keyframes: &two, is_cycle: false, fps: KeyframePath::FPS };
    assert!(path.pictures().any(|(pose, _)| near(&poses[2], &pose)), "{:?}", poses[2]);
    view.go_to(poses[2][..].try_into().unwrap());
    let (size, rgb) = read_png(&picture_path);
    let seen = picture(&file, &view.camera(width, height), file.about.quality.unwrap_or(0.5));
    let off = rgb.iter().zip(&seen).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(size == [width, height] && off < 30, "{off}");
    assert_eq!(saved["camera_path"].as_array().unwrap().len(), 120);

    // What is no camera path stays, and a line says so.
    std::fs::write(&script, "key k\nkey w\n").unwrap();
    let other = folder.path().join("notes.json");
    std::fs::write(&other, "{}").unwrap();
    let arguments = ["--script", script.to_str().unwrap(), "--save-path", other.to_str().unwrap()];
    let said = ended(start(&display, &arguments, folder.path()));
    let line =
        format!("{}: kept, it is no camera path; give another --save-path\n", other.display());
    assert!(said.starts_with(&line), "{said}");
    assert_eq!(std::fs::read_to_string(&other).unwrap(), "{}");
}
