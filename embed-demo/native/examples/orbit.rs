//! Renders an orbit of a `.pnerf` file: `pocketnerf-embed-demo [MODEL [FOLDER]]`,
//! without arguments of the model that is part of this program.
//!
//! All that an embedding program needs: open the bytes, size the scratch, and
//! call `render_tile` from as many threads as it likes.

use std::borrow::Cow;
use std::error::Error;
use std::f32::consts::TAU;
use std::path::Path;

use pocketnerf_core::{Camera, Model, RenderOptions, SimdLevel, Tile, Tuning, math, render_tile};
use rayon::prelude::*;

/// What `pocketnerf demo --log2-hashmap-size 12` made of the built-in scene.
const STILL_LIFE: &[u8] = include_bytes!("../still-life.pnerf");
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
    let file = pocketnerf_formats::open_verified(&bytes).map_err(|e| format!("{name}: {e}"))?;
    // Where there is memory to spare: the same pictures in less time.
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
    let radius = 1.6 / model.space.unit_map().scale;
    let (sin, cos) = math::sin_cos(TAU * view as f32 / VIEWS as f32);
    let eye = [target[0] + radius * cos, target[1] + radius * sin, target[2] + 0.5 * radius];
    Camera::from_fov_x(SIDE, SIDE, 0.7, Camera::look_at(eye, target, [0.0, 0.0, 1.0]))
}

/// One row of pixels a task, on all cores.
fn picture(model: &Model<'_>, camera: &Camera) -> Result<Vec<u8>, pocketnerf_core::Error> {
    let options = RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST);
    let background = model.display.background;
    let rows: Result<Vec<Vec<u8>>, _> = (0..camera.height)
        .into_par_iter()
        .map_init(
            || (vec![0.0; options.scratch_len()], vec![0.0; 4 * camera.width as usize]),
            |(scratch, rgba), y| {
                let tile = Tile { x: 0, y, width: camera.width, height: 1 };
                render_tile(model, camera, tile, &options, scratch, rgba, None)?;
                let over = |p: &[f32; 4]| [0, 1, 2].map(|c| p[c] + (1.0 - p[3]) * background[c]);
                let to_byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
                Ok(rgba.as_chunks::<4>().0.iter().flat_map(|p| over(p).map(to_byte)).collect())
            },
        )
        .collect();
    Ok(rows?.concat())
}
