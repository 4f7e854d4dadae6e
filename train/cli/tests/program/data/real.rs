//! `pocketnerf prepare` with COLMAP and ffmpeg, where they are installed.

use std::path::PathBuf;
use std::process::Command;

use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::{LoadOptions, Split, load_with};
use pocketnerf_train::picture::image_file;

use super::shop::{COLMAP, Shop};
use crate::place::Place;

/// The program of this name that is installed, unless it is missing.
fn installed(name: &str) -> Option<PathBuf> {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&paths).map(|path| path.join(name)).find(|p| p.is_file());
    if found.is_none() {
        let required = std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_some();
        assert!(!required, "{name} is not installed, and POCKETNERF_REQUIRE_TOOLS is set");
        println!("skipped: {name} is not installed");
    }
    found
}

#[test]
fn ffmpeg_itself() {
    let (Some(ffmpeg), Some(ffprobe)) = (installed("ffmpeg"), installed("ffprobe")) else { return };
    let shop = Shop::new(&[("colmap", COLMAP)]);
    std::os::unix::fs::symlink(&ffmpeg, shop.place.path("bin/ffmpeg")).unwrap();
    std::os::unix::fs::symlink(ffprobe, shop.place.path("bin/ffprobe")).unwrap();
    // Twelve pictures, one a second, that become brighter.
    for i in 0..12u8 {
        let file = shop.place.path(&format!("data/grey{i:02}.png"));
        image::GrayImage::from_pixel(64, 48, image::Luma([20 * i])).save(file).unwrap();
    }
    let pictures = shop.place.path("data/grey%02d.png");
    let made = Command::new(ffmpeg)
        .args(["-v", "error", "-framerate", "1", "-i"])
        .arg(pictures)
        .args(["-c:v", "mpeg4", "-q:v", "1"])
        .arg(shop.place.path("walk.mp4"))
        .status();
    assert!(made.unwrap().success());
    shop.ok("prepare walk.mp4 --frames 6 --out set --quiet --json");
    let frames: Vec<u8> = (1..=6)
        .map(|i| {
            let frame =
                image_file::open(shop.place.path(&format!("set/images/{i:05}.jpg"))).unwrap();
            assert_eq!((frame.width(), frame.height()), (64, 48));
            frame.into_luma8().get_pixel(30, 20).0[0]
        })
        .collect();
    // From the first to the last, each about two pictures on.
    assert!(frames.windows(2).all(|pair| (20..=60).contains(&(pair[1] - pair[0]))), "{frames:?}");
    assert!(frames[0] <= 40 && frames[5] >= 180, "{frames:?}");
    let line = {
        std::fs::write(shop.place.path("broken.mp4"), "no video").unwrap();
        shop.line("prepare broken.mp4 --out other", &[])
    };
    assert!(line.ends_with("no video that can be read; give another file"), "{line}");
}

/// Cameras that COLMAP finds are those that photographs were taken with, but for scale and axes.
#[test]
fn colmap_itself() {
    if installed("colmap").is_none() {
        return;
    }
    let place = Place::new();
    std::fs::create_dir(place.path("photos")).unwrap();
    let truth = Scene::StillLife.dataset(Split::Train, 1);
    let views: Vec<_> = truth.views.iter().take(36).collect();
    for (i, view) in views.iter().enumerate() {
        let size = (view.camera.width, view.camera.height);
        let rgb: Vec<u8> = view.rgba.chunks(4).flat_map(over_grey).collect();
        let file = place.path(&format!("photos/{i:02}.png"));
        image::save_buffer(file, &rgb, size.0, size.1, image::ColorType::Rgb8).unwrap();
    }
    let result = place.ok("prepare photos --out set --quiet --json");
    assert!(result["registered"].as_u64().unwrap() >= 30, "{result}");
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    let found = load_with(&place.path("set"), Split::Train, &options).unwrap();
    let number = |name: &str| name.trim_start_matches("images/")[..2].parse::<usize>().unwrap();
    let pairs: Vec<_> = found
        .views
        .iter()
        .map(|v| (v.camera.axis(), views[number(&v.name)].camera.axis()))
        .collect();
    // Angles between cameras are the same in any world.
    let mut off = Vec::new();
    for (i, a) in pairs.iter().enumerate() {
        for b in &pairs[..i] {
            let angle = |a: [f32; 3], b: [f32; 3]| {
                let dot: f32 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                dot.clamp(-1.0, 1.0).acos().to_degrees()
            };
            off.push((angle(a.0, b.0) - angle(a.1, b.1)).abs());
        }
    }
    off.sort_by(f32::total_cmp);
    assert!(
        off[off.len() / 2] < 1.0,
        "half of the angles are off by {} degrees",
        off[off.len() / 2]
    );
}

/// A pixel over grey.
fn over_grey(pixel: &[u8]) -> [u8; 3] {
    let alpha = f32::from(pixel[3]) / 255.0;
    [0, 1, 2].map(|c| (f32::from(pixel[c]) * alpha + 128.0 * (1.0 - alpha)) as u8)
}
