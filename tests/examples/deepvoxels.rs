//! Writes a scene as DeepVoxels' are (Sitzmann et al. 2019): one body on white, seen from a
//! hemisphere, in 512x512 pixels.
//!
//! ```sh
//! cargo run --release -p pocketnerf-tests --example deepvoxels -- FOLDER
//! pocketnerf train FOLDER --downscale-factor 4
//! ```
//!
//! The body is the built-in still life. Training views are spread evenly over the hemisphere, as
//! those of DeepVoxels; the others follow a spiral upwards (Archimedes'), as there.

use std::error::Error;
use std::f32::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use pocketnerf_core::Camera;
use pocketnerf_core::pixel::over;
use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::View;

const SIDE: u32 = 512;
/// Of the hemisphere, scene units: that of the still life's own cameras.
const RADIUS: f32 = 4.0;
const FOV_X: f32 = 0.7;
/// What is looked at: the scene's middle.
const TARGET: [f32; 3] = [0.0; 3];
/// How much smaller the scene is written: DeepVoxels' reach 1 from the middle.
const SCALE: f32 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).ok_or("expected a folder to write the scene to")?;
    let folder = Path::new(&folder);
    let golden = (5f32.sqrt() - 1.0) / 2.0;
    for (split, n) in [("train", 120), ("validation", 12), ("test", 24)] {
        let camera = |i: usize| {
            let share = (i as f32 + 0.5) / n as f32;
            let turns = match split {
                "train" => golden * i as f32,
                "test" => 4.0 * share,
                _ => 3.0 * share + 0.1,
            };
            // Not quite to the rim, nor to the pole.
            on_hemisphere(turns, 0.05 + 0.9 * share)
        };
        let cameras: Vec<Camera> = (0..n).map(camera).collect();
        write(&folder.join(split).join("still-life"), &Scene::StillLife.views(&cameras, split))?;
    }
    Ok(())
}

/// The camera so many turns around, at a height of this share of the radius.
fn on_hemisphere(turns: f32, height: f32) -> Camera {
    let (sin, cos) = (TAU * turns).sin_cos();
    let around = (1.0 - height * height).sqrt();
    let eye = [around * cos, around * sin, height].map(|c| RADIUS * c);
    let pose = Camera::look_at(eye, TARGET, [0.0, 0.0, 1.0]);
    Camera::from_fov_x(SIDE, SIDE, FOV_X, pose)
}

fn write(folder: &Path, views: &[View]) -> Result<(), Box<dyn Error>> {
    for inside in ["rgb", "pose"] {
        std::fs::create_dir_all(folder.join(inside))?;
    }
    for (i, view) in views.iter().enumerate() {
        let white = |pixel: &[u8; 4]| {
            let [r, g, b, a] = pixel.map(|value| f32::from(value) / 255.0);
            over([r * a, g * a, b * a, a], [1.0; 3]).map(|value| (value * 255.0).round() as u8)
        };
        let rgb: Vec<u8> = view.rgba.as_chunks().0.iter().flat_map(white).collect();
        image::save_buffer(
            folder.join(format!("rgb/{i:06}.png")),
            &rgb,
            view.camera.width,
            view.camera.height,
            image::ColorType::Rgb8,
        )?;
        // OpenCV's axes: right, down, forward.
        let mut pose = String::new();
        for row in view.camera.camera_to_world.as_chunks::<4>().0.iter().take(3) {
            let [right, up, back, place] = *row;
            write!(pose, "{right} {} {} {} ", -up, -back, SCALE * place)?;
        }
        std::fs::write(folder.join(format!("pose/{i:06}.txt")), pose + "0 0 0 1\n")?;
    }
    let [focal, middle] = [views[0].camera.focal[0], SIDE as f32 / 2.0];
    let intrinsics = format!("{focal} {middle} {middle} 0.\n0. 0. 0.\n1.\n1.\n{SIDE} {SIDE}\n");
    Ok(std::fs::write(folder.join("intrinsics.txt"), intrinsics)?)
}
