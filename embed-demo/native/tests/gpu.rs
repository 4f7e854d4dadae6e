//! The window's pictures on a GPU; a software GPU will do.

mod common;

use common::{STILL_LIFE, read_png, viewer};
use pocketnerf_gpu::{Gpu, Software};
use pocketnerf_view::paint::Painter;
use pocketnerf_view::paint::modes::Mode;
use pocketnerf_view::show::Show;
use pocketnerf_view::view::View;

/// The GPU, if there is one; without one where tools are required, the tests fail.
fn gpu() -> Option<Gpu> {
    match Gpu::open(Software::Allowed) {
        Ok(gpu) => Some(gpu),
        Err(why) => {
            assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "{why}");
            println!("{why}: nothing is tested");
            None
        }
    }
}

/// Values that differ by more than two levels.
fn far_off(a: &[u8], b: &[u8]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 2).count()
}

#[test]
fn pictures_are_those_of_the_cpu() {
    if gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for mode in ["colour", "depth", "occupancy"] {
        let [gpu, cpu] = ["gpu", "cpu"].map(|device| {
            let path = folder.path().join(format!("{device}.png"));
            let mut command = viewer();
            command.args(["--headless", "--size", "70x90", "--quality", "1", "--mode", mode]);
            command.args(["--device", device]).env("POCKETNERF_SOFTWARE_GPU", "1");
            let output = command.arg("--out").arg(&path).output().unwrap();
            assert!(output.status.success(), "{output:?}");
            assert!(!String::from_utf8_lossy(&output.stderr).contains("warning"), "{output:?}");
            read_png(&path)
        });
        assert_eq!(gpu.0, [70, 90]);
        assert!(far_off(&gpu.1, &cpu.1) < 70 * 90 * 3 / 100, "{mode}: {}", far_off(&gpu.1, &cpu.1));
    }
}

/// A window of it, as if one were open: tile by tile, and with the name of the GPU.
#[test]
fn a_window_is_complete_after_a_while() {
    let Some(gpu) = gpu() else { return };
    let bytes = pocketnerf_formats::unpacked(STILL_LIFE).unwrap();
    let file = pocketnerf_formats::open(&bytes).unwrap();
    let whole = |painter: Painter<'_>| {
        let mut show = Show::new(painter, View::new(&file), Mode::Colour, 1.0, 30.0);
        show.resize([150, 130]);
        while !show.is_at_rest() {
            show.work().unwrap();
        }
        (show.shown().rgb(), show.painter().gpu())
    };
    let painter = || Painter::new(&file.model, 1).unwrap();
    let (found, status) = whole(painter().on(&gpu));
    let (expected, none) = whole(painter());
    assert_eq!((status, none), (Some(format!("on {}", gpu.name())), None));
    assert!(far_off(&found, &expected) < found.len() / 100, "{}", far_off(&found, &expected));
}
