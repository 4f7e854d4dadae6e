//! Writes views of a built-in scene, composited on white, as PNG files:
//! `cargo run --release --example builtin_scene -- FOLDER [NAME]`.

use pocketnerf_train::builtin::{self, Scene};
use pocketnerf_train::dataset::Split;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder: PathBuf = std::env::args_os().nth(1).ok_or("which folder to write to?")?.into();
    let name = std::env::args().nth(2).unwrap_or_else(|| Scene::StillLife.name().to_owned());
    let scene = Scene::named(&name).ok_or("no such scene")?;
    for split in [Split::Train, Split::Test] {
        let start = std::time::Instant::now();
        let dataset = scene.dataset(split, 1);
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{} views in {seconds:.2} s, {:016x}",
            dataset.views.len(),
            builtin::content_hash(&dataset)
        );
        for view in &dataset.views {
            let white = |c: u8, a: u8| 255 - ((255 - u32::from(c)) * u32::from(a) + 127) / 255;
            let rgb: Vec<u8> = view
                .rgba
                .as_chunks::<4>()
                .0
                .iter()
                .flat_map(|&[r, g, b, a]| [r, g, b].map(|c| white(c, a) as u8))
                .collect();
            let path = folder.join(&view.name).with_extension("png");
            std::fs::create_dir_all(path.parent().ok_or("a folder")?)?;
            image::save_buffer(
                &path,
                &rgb,
                view.camera.width,
                view.camera.height,
                image::ColorType::Rgb8,
            )?;
        }
    }
    Ok(())
}
