//! Renders views on a circle around a model: `cargo run --release -p pocketnerf-view --example
//! orbit [MODEL [FOLDER]]`; by default, of the model that is part of this program.
//!
//! All that an embedding program needs: open the bytes, allocate the scratch, and call
//! `render_tile` from any number of threads. It uses core and formats alone.

use std::borrow::Cow;
use std::error::Error;
use std::f32::consts::TAU;
use std::path::Path;

use pocketnerf_core::camera::Orbit;
use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Camera, Model, RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use rayon::prelude::*;

/// The model that `pocketnerf demo --log2-hashmap-size 12` makes of the built-in scene.
const STILL_LIFE: &[u8] = include_bytes!("../../still-life.pnerf");
const VIEWS: u32 = 8;
const SIDE: u32 = 400;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (model, folder) = (arguments.next(), arguments.next());
    let (name, bytes) = match &model {
        Some(path) => {
            let bytes = std::fs::read(path).map_err(|e| format!("{path}: {e}"))?;
            (path.as_str(), Cow::Owned(bytes))
        }
        None => ("the built-in model", Cow::Borrowed(STILL_LIFE)),
    };
    let folder = folder.as_deref().unwrap_or("out/orbit");
    let bytes = pocketnerf_formats::unpacked(&bytes).map_err(|e| format!("{name}: {e}"))?;
    let file = pocketnerf_formats::open_verified(&bytes).map_err(|e| format!("{name}: {e}"))?;
    // The same pictures in less time, for some memory.
    let mut table = vec![0; file.model.table_len()];
    let model = file.model.with_table(&mut table)?;
    std::fs::create_dir_all(folder)?;
    for view in 0..VIEWS {
        let camera = orbit(&model, view);
        let rgb = picture(&model, &camera)?;
        let path = Path::new(folder).join(format!("{view:02}.png"));
        image::save_buffer(&path, &rgb, SIDE, SIDE, image::ColorType::Rgb8)?;
    }
    println!("{folder}: {VIEWS} pictures");
    Ok(())
}

/// A camera on a circle around the scene, z up.
fn orbit(model: &Model<'_>, view: u32) -> Camera {
    let target = model.space.center();
    let radius = 0.9 * model.space.viewing_distance();
    let (azimuth, up) = (TAU * view as f32 / VIEWS as f32, [0.0, 0.0, 1.0]);
    let orbit = Orbit { target, radius, azimuth, elevation: 0.46, axis: up, up };
    Camera::from_fov_x(SIDE, SIDE, 0.7, orbit.pose())
}

/// Red, green and blue of every pixel: one task per tile, on all cores.
fn picture(model: &Model<'_>, camera: &Camera) -> Result<Vec<u8>, pocketnerf_core::Error> {
    let options = RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST);
    let memory = || (vec![0.0; options.scratch_len()], vec![0.0; 4 * Tiles::MOST_PIXELS]);
    let paint = |(scratch, rgba): &mut (Vec<f32>, Vec<f32>), tile: Tile| {
        render_tile(model, camera, tile, &options, scratch, rgba, None)?;
        let pixels = &rgba.as_chunks::<4>().0[..tile.pixels()];
        Ok((tile, pixels.iter().map(|p| model.display.rgb8(*p)).collect::<Vec<_>>()))
    };
    let tiles: Vec<Tile> = Tiles::new(camera.width, camera.height).collect();
    let tiles: Result<Vec<_>, _> = tiles.into_par_iter().map_init(memory, paint).collect();
    let row = camera.width as usize;
    let mut rgb = vec![[0; 3]; row * camera.height as usize];
    for (tile, pixels) in tiles? {
        let rows = rgb.chunks_exact_mut(row).skip(tile.y as usize);
        for (row, pixels) in rows.zip(pixels.chunks_exact(tile.width as usize)) {
            row[tile.x as usize..][..pixels.len()].copy_from_slice(pixels);
        }
    }
    Ok(rgb.into_flattened())
}
