//! What the short cuts of rendering cost on a trained model:
//!
//! ```sh
//! cargo run --release -p pocketnerf-tests --example safety -- MODEL DATA
//! ```
//!
//! Renders the test views as they are, without skipping, and with the occupied
//! cells grown by one in every direction; and every 997th pixel by the plain
//! f64 renderer, which visits every step.

use std::error::Error;
use std::path::Path;

use pocketnerf_core::reference::render_ray;
use pocketnerf_core::{Model, Occupancy};
use pocketnerf_train::dataset::{self, Dataset, Split};
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::Settings;
use pocketnerf_train::trainer::{dilated, pack};
use pocketnerf_train::{metrics, picture};
use rayon::prelude::*;

/// A prime, so that all columns have their turn.
const PIXELS_APART: usize = 997;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, data] = arguments.as_slice() else {
        return Err("expected two arguments: MODEL DATA".into());
    };
    let bytes = std::fs::read(model).map_err(|e| format!("{model}: {e}"))?;
    let bytes = pocketnerf_formats::unpacked(&bytes).map_err(|e| format!("{model}: {e}"))?;
    let file = pocketnerf_formats::open_verified(&bytes).map_err(|e| format!("{model}: {e}"))?;
    let dataset = dataset::load(Path::new(data), Split::Test, 1)?;
    let background = file.model.display.background;
    let finest = Settings { quality: 1.0, ..Settings::default() };
    let score = |model: &Model<'_>, settings: Settings| {
        evaluate(model, &dataset, background, &settings, &Metrics::default(), |_, _, _| ())
            .map(|result| result.psnr)
    };
    let fast = score(&file.model, finest)?;
    println!("every pixel      {fast:.4} dB");
    let usual = score(&file.model, Settings::default())?;
    println!("usual quality    {:+.4} dB", usual - fast);
    let unskipped = score(&file.model, Settings { skip: false, ..finest })?;
    println!("without skipping {:+.4} dB", unskipped - fast);
    if let Some(occupancy) = file.model.occupancy {
        let (coarse, fine) = pack(occupancy.resolution(), dilated(&occupancy).into_iter()).unwrap();
        let grown = Occupancy::new(occupancy.resolution(), 1, &coarse, &fine)?;
        let grown = score(&Model { occupancy: Some(grown), ..file.model }, finest)?;
        println!("grown by a cell  {:+.4} dB", grown - fast);
    }
    let [fast, reference, largest] = against_reference(&file.model, &dataset, background, &finest)?;
    println!(
        "reference        {:+.4} dB on every {PIXELS_APART}th pixel, largest difference {largest:.2e}",
        reference - fast
    );
    Ok(())
}

/// PSNR of both renderers and the largest difference of a channel.
fn against_reference(
    model: &Model<'_>,
    dataset: &Dataset,
    background: [f32; 3],
    finest: &Settings,
) -> Result<[f64; 3], Box<dyn Error>> {
    let (mut fast, mut slow, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    for view in &dataset.views {
        let rendered = picture::render(model, &view.camera, finest)?;
        let rendered = rendered.over(background);
        let target = metrics::composite_on(&view.rgba, background);
        let width = view.camera.width as usize;
        let pixels: Vec<usize> = (0..target.len() / 3).step_by(PIXELS_APART).collect();
        let traced: Result<Vec<[f32; 3]>, _> = pixels
            .par_iter()
            .map(|i| {
                let ray = view.camera.ray((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
                render_ray(model, &ray).map(|result| result.over(background))
            })
            .collect();
        slow.extend(traced?.into_iter().flatten());
        for i in pixels {
            fast.extend_from_slice(&rendered[3 * i..3 * i + 3]);
            truth.extend_from_slice(&target[3 * i..3 * i + 3]);
        }
    }
    let largest = fast.iter().zip(&slow).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let truth = metrics::quantize_all(&truth);
    let psnr = |values: &[f32]| metrics::psnr(&metrics::quantize_all(values), &truth);
    Ok([psnr(&fast), psnr(&slow), largest.into()])
}
