//! The program for a bare microcontroller, under QEMU.
//!
//! Needs `qemu-system-arm`; without it nothing is tested, unless `POCKETNERF_REQUIRE_TOOLS` is
//! set.

use std::path::{Path, PathBuf};
use std::process::Command;

use pocketnerf_core::reference::render_pixel;
use pocketnerf_core::{Camera, ColorSpace, pixel};

const SIDE: usize = 64;
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// What the display showed, and what the program said of it.
struct Run {
    rgb: Vec<u8>,
    said: String,
}

impl Run {
    /// `None` where there is no QEMU.
    fn new(model: &Path, options: &[&str]) -> Option<Self> {
        if !Command::new("qemu-system-arm")
            .arg("--version")
            .output()
            .is_ok_and(|o| o.status.success())
        {
            let text = "no qemu-system-arm: the microcontroller is not tested";
            assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "{text}");
            eprintln!("{text}");
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("display.ppm");
        // The compiler that tests are built with is not always that of the bare target.
        let mut command = Command::new(Path::new(ROOT).join("embed-demo/cortex-m/run"));
        command.arg(&picture).args(options).env("POCKETNERF_MODEL", model);
        let output = command.env_remove("CARGO").output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        let bytes = std::fs::read(&picture).unwrap();
        let rgb = bytes.strip_prefix(b"P6 64 64 255\n").unwrap().to_vec();
        assert_eq!(rgb.len(), 3 * SIDE * SIDE);
        Some(Self { rgb, said })
    }

    fn number(&self, name: &str) -> u64 {
        let line = self.said.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.unwrap_or_else(|| panic!("{name}: {}", self.said)).parse().unwrap()
    }

    /// White letters on red.
    fn is_message(&self) -> bool {
        let pixels = self.rgb.as_chunks::<3>().0;
        let letters = pixels.iter().filter(|p| **p == [255; 3]).count();
        letters > 20
            && pixels.iter().filter(|p| **p == [160, 0, 0]).count() == pixels.len() - letters
    }
}

fn still_life() -> PathBuf {
    Path::new(ROOT).join("embed-demo/still-life.pnerf")
}

/// dB, against the oracle.
fn psnr(run: &Run, model: &Path) -> f64 {
    let bytes = std::fs::read(model).unwrap();
    let file = pocketnerf_formats::open(&bytes).unwrap();
    let own = file.about.camera.unwrap();
    let camera = Camera::from_fov_x(SIDE as u32, SIDE as u32, own.fov_x, own.camera_to_world);
    let truth = (0..SIDE * SIDE).flat_map(|i| {
        let pixel = render_pixel(&file.model, &camera, (i % SIDE) as u32, (i / SIDE) as u32);
        pixel::rgb8(pixel.unwrap().over(file.model.display.background), ColorSpace::Srgb)
    });
    let squares: u32 = truth.zip(&run.rgb).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum();
    20.0 * 255f64.log10() - 10.0 * (f64::from(squares) / run.rgb.len() as f64).log10()
}

/// One after another: they share a build folder.
#[test]
fn a_microcontroller_shows_a_model_or_says_why_not() {
    let Some(run) = Run::new(&still_life(), &[]) else { return };
    println!("{}", run.said);
    let bytes = std::fs::read(still_life()).unwrap();
    let psnr = psnr(&run, &still_life());
    println!("{psnr:.1} dB of the oracle");
    assert!(psnr >= 50.0, "{psnr}");
    // All of RAM, as far as it was ever used.
    let [variables, stack] = ["static_ram", "stack"].map(|name| run.number(name));
    let (found, most) = (variables + stack, 64 << 10);
    println!("{found} bytes of RAM, of {most}");
    assert!(variables > 30_000 && stack > 1000 && found <= most, "{found} bytes of {most}");
    assert!(run.number("instructions_to_render") > 1000 * run.number("rays"));

    let mut messages = Vec::new();
    let folder = tempfile::tempdir().unwrap();
    let damaged = folder.path().join("damaged.pnerf");
    std::fs::write(&damaged, &bytes[..bytes.len() / 2]).unwrap();
    let golden = |name: &str| Path::new(ROOT).join("tests/golden").join(name);
    // Voxels, in a program that has no other kind.
    let voxels: &[&str] = &["--no-default-features", "--features", "plenoxels"];
    let run = Run::new(&golden("plenoxels-i8.pnerf"), voxels).unwrap();
    let psnr = self::psnr(&run, &golden("plenoxels-i8.pnerf"));
    println!("voxels: {psnr:.1} dB of the oracle");
    assert!(psnr >= 50.0 && run.number("samples") > 1000, "{psnr}: {}", run.said);
    for (model, options) in [
        (still_life(), &["--features", "less-memory"][..]),
        (golden("nerf-f16.pnerf"), &[]),
        (Path::new(ROOT).join("README.md"), &[]),
        (damaged, &[]),
    ] {
        let run = Run::new(&model, options).unwrap();
        assert!(run.is_message(), "{}", model.display());
        assert_eq!(run.number("samples"), 0);
        messages.push(run.rgb);
    }
    messages.sort();
    messages.dedup();
    assert_eq!(messages.len(), 4, "each says something else");
}
