//! `pocketnerf view`, and `pocketnerf train --view`.

mod terminal;
mod window;

use pocketnerf_train::picture::image_file;
use std::process::{Command, Output};
use std::sync::OnceLock;

use crate::place::{Place, TRAIN};

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../embed-demo/still-life.pnerf");

/// Steps of a run that is long enough to be watched.
const STEPS: u32 = 600;

/// The model of a run of so many steps that nobody watches.
fn alone() -> &'static [u8] {
    static ALONE: OnceLock<Vec<u8>> = OnceLock::new();
    ALONE.get_or_init(|| {
        let place = Place::new();
        place.ok(&format!("{TRAIN} --steps {STEPS} --out alone.pnerf"));
        place.bytes("alone.pnerf")
    })
}

/// The program where there is no display.
fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn pictures_are_those_of_render() {
    let folder = tempfile::tempdir().unwrap();
    let [viewed, rendered] = ["view", "render"].map(|name| {
        let path = folder.path().join(name).with_extension("png");
        let size: &[&str] = match name {
            "view" => &["--headless", "--size", "96x96"],
            // One ray a pixel, as in a window.
            _ => &["--width", "96", "--height", "96", "--antialias", "off"],
        };
        let mut command = program();
        let output =
            command.args([name, MODEL]).args(size).arg("--out").arg(&path).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        image_file::open(path).unwrap().to_rgb8()
    });
    assert!(viewed.dimensions() == (96, 96) && viewed == rendered);
    let output = program().args(["view", MODEL, "--terminal", "--width", "9"]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!((text.lines().count(), text.matches('▀').count()), (5, 9 * 5), "{text}");
}

#[test]
fn what_view_cannot_do_is_told_in_a_line() {
    for (options, expected) in [
        (&[][..], "or without one --headless --out FILE.png, or --terminal"),
        (&["--json"], "view: --json: expected none; `pocketnerf render --json` has figures"),
    ] {
        let output = program().args(["view", MODEL]).args(options).output().unwrap();
        let line = said(&output);
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(line.starts_with("pocketnerf: ") && line.matches('\n').count() == 1, "{line}");
        assert!(line.trim_end().ends_with(expected), "{line}");
    }
}
