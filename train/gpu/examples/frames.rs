//! Times pictures of a model on the GPU and on one thread of the CPU, and compares them.
//!
//! `cargo run --release -p pocketnerf-gpu --example frames -- MODEL [WIDTH]`
//!
//! With `POCKETNERF_SOFTWARE_GPU` set, a software GPU will do.

use std::time::Instant;

use pocketnerf_core::render::Detail;
use pocketnerf_core::{Camera, RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use pocketnerf_gpu::{Gpu, Renderer, Software};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("usage: frames MODEL [WIDTH]")?;
    let width: Option<u32> = args.next().map(|width| width.parse()).transpose()?;
    let bytes = pocketnerf_formats::unpacked(&std::fs::read(path)?)?.into_owned();
    let file = pocketnerf_formats::open(&bytes)?;
    let own = file.about.camera.ok_or("a model without a camera")?;
    let width = width.unwrap_or(own.width);
    let camera = Camera::from_fov_x(width, width, own.fov_x, own.camera_to_world);
    let usual = RenderOptions::new(&file.model, SimdLevel::detect(), Tuning::FAST);
    let finest = RenderOptions { detail: Detail::FINEST, ..usual };

    let begun = Instant::now();
    let gpu = Gpu::open(Software::from_environment())?;
    println!("{}: opened in {:.0} ms", gpu.name(), 1e3 * begun.elapsed().as_secs_f64());
    for (what, options) in [("every sample", finest), ("usual quality", usual)] {
        let begun = Instant::now();
        let mut renderer = Renderer::new(&gpu, &file.model, &options)?;
        println!("{what}: compiled in {:.0} ms", 1e3 * begun.elapsed().as_secs_f64());
        // Until the first pictures have shown how much may be asked for at a time.
        for _ in 0..8 {
            renderer.render(&camera)?;
        }
        let begun = Instant::now();
        let mut n = 0;
        while n < 3 || (n < 300 && begun.elapsed().as_secs_f64() < 2.0) {
            renderer.render(&camera)?;
            n += 1;
        }
        let seconds = begun.elapsed().as_secs_f64() / f64::from(n);
        let picture = renderer.render(&camera)?;
        let pixels = f64::from(width).powi(2);
        println!(
            "{what}: {:.2} ms a frame of {width}x{width}, {:.2} samples a pixel",
            1e3 * seconds,
            picture.samples as f64 / pixels
        );
        let tile = Tile { x: 0, y: 0, width, height: width };
        let mut scratch = vec![0.0; options.scratch_len()];
        let mut expected = vec![0.0; picture.rgba.len()];
        let begun = Instant::now();
        render_tile(&file.model, &camera, tile, &options, &mut scratch, &mut expected, None)?;
        let squares = expected.iter().zip(&picture.rgba).map(|(a, b)| f64::from(a - b).powi(2));
        println!(
            "{what}: a thread of the CPU takes {:.2} ms; the pictures differ by {:.1} dB",
            1e3 * begun.elapsed().as_secs_f64(),
            -10.0 * (squares.sum::<f64>() / expected.len() as f64).log10()
        );
    }
    Ok(())
}
