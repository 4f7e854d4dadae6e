//! The picture that the Rust API gives, and the program.

#![allow(dead_code, reason = "each test uses a part")]

use std::path::PathBuf;
use std::process::Command;

use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Camera, RenderOptions, SimdLevel, Tuning, render_tile};
use pocketnerf_formats::ModelFile;

pub(crate) const STILL_LIFE: &[u8] = include_bytes!("../../../still-life.pnerf");

/// A file of the repository.
pub(crate) fn repository(path: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path)
}

pub(crate) fn viewer() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf-view"));
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command
}

/// RGB bytes: tile after tile on one thread.
pub(crate) fn picture(file: &ModelFile<'_>, camera: &Camera, quality: f32) -> Vec<u8> {
    let model = &file.model;
    let options = RenderOptions {
        detail: model.detail(quality),
        ..RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST)
    };
    let mut scratch = vec![0.0; options.scratch_len()];
    let row = camera.width as usize;
    let mut rgb = vec![0; 3 * row * camera.height as usize];
    for tile in Tiles::new(camera.width, camera.height) {
        let mut rgba = vec![0.0; 4 * tile.pixels()];
        render_tile(model, camera, tile, &options, &mut scratch, &mut rgba, None).unwrap();
        for (i, p) in rgba.as_chunks::<4>().0.iter().enumerate() {
            let (x, y) = (i % tile.width as usize, i / tile.width as usize);
            let at = 3 * ((tile.y as usize + y) * row + tile.x as usize + x);
            rgb[at..at + 3].copy_from_slice(&model.display.rgb8(*p));
        }
    }
    rgb
}

/// Size and RGB bytes of a PNG file.
pub(crate) fn read_png(path: impl AsRef<std::path::Path>) -> ([u32; 2], Vec<u8>) {
    let image = image::load_from_memory(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(image.color(), image::ColorType::Rgb8);
    ([image.width(), image.height()], image.into_bytes())
}
