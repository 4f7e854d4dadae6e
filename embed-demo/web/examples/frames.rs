//! Milliseconds of frames of a model's own camera, on one thread at the SSE4.2 level (four lanes, as
//! WebAssembly has): `frames MODEL SIDE N`. What `speed.mjs` compares a browser's code with.

use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_web::Scene;

fn main() -> Result<(), String> {
    let arguments: Vec<_> = std::env::args().collect();
    let [_, path, side, n] = &arguments[..] else { return Err("frames MODEL SIDE N".into()) };
    let bytes = std::fs::read(path).map_err(|error| format!("{path}: {error}"))?;
    let number = |text: &str| text.parse::<u32>().map_err(|error| format!("{text}: {error}"));
    let (side, n) = (number(side)?, number(n)?);
    let mut scene = Scene::open(bytes.leak(), SimdLevel::Sse42)?;
    let (camera, quality) = (scene.own_camera(side, side), scene.facts().quality());
    let mut times = Vec::new();
    for _ in 0..n {
        let begun = Instant::now();
        for tile in 0..scene.begin(&camera, quality)? {
            scene.tile(tile, false)?;
        }
        times.push(format!("{:.3}", begun.elapsed().as_secs_f64() * 1e3));
    }
    println!("[{}]", times.join(","));
    Ok(())
}
