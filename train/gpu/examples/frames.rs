//! Times pictures of a model on the GPU and on all threads of the CPU, and compares them.
//!
//! `cargo run --release -p pocketnerf-gpu --example frames -- MODEL [WIDTH] [SECONDS]`
//!
//! With `POCKETNERF_SOFTWARE_GPU` set, a software GPU will do.

use std::sync::Mutex;
use std::time::Instant;

use pocketnerf_core::render::{Detail, Tiles};
use pocketnerf_core::{Camera, Error, Model, RenderOptions, SimdLevel, Tuning, render_tile};
use pocketnerf_gpu::{Gpu, Renderer, Software};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("usage: frames MODEL [WIDTH] [SECONDS]")?;
    let width: Option<u32> = args.next().map(|width| width.parse()).transpose()?;
    let seconds: f64 = args.next().map_or(Ok(2.0), |seconds| seconds.parse())?;
    let bytes = pocketnerf_formats::unpacked(&std::fs::read(path)?)?.into_owned();
    let file = pocketnerf_formats::open(&bytes)?;
    let model = &file.model;
    let own = file.about.camera.ok_or("a model without a camera")?;
    let width = width.unwrap_or(own.width);
    let camera = Camera::from_fov_x(width, width, own.fov_x, own.camera_to_world);
    let usual = RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST);
    let finest = RenderOptions { detail: Detail::FINEST, ..usual };

    let begun = Instant::now();
    let gpu = Gpu::open(Software::from_environment())?;
    println!("{}: opened in {:.0} ms", gpu.name(), 1e3 * begun.elapsed().as_secs_f64());
    println!("pictures of {width}x{width}, every pixel rendered");
    for (what, options) in [("every sample", finest), ("usual quality", usual)] {
        let begun = Instant::now();
        let mut renderer = Renderer::new(&gpu, model, &options)?;
        println!("{what}: compiled in {:.0} ms", 1e3 * begun.elapsed().as_secs_f64());
        // Until the first pictures have shown how much may be asked for at a time.
        for _ in 0..8 {
            renderer.render(&camera)?;
        }
        let read = time(seconds, || Ok(renderer.render(&camera).map(|_| ())?))?;
        let drawn = time(seconds, || Ok(renderer.draw(&camera)?))?;
        renderer.finish()?;
        let shown = time(seconds, || {
            renderer.draw(&camera)?;
            Ok(renderer.rgba8(&model.display).map(|_| ())?)
        })?;
        let is_timed = renderer.set_timed()?;
        let picture = renderer.render(&camera)?.clone();
        let samples = picture.samples as f64 / f64::from(width).powi(2);
        println!("{what}: {samples:.2} samples a pixel");
        if is_timed {
            let mut sum = 0.0;
            for _ in 0..30 {
                renderer.render(&camera)?;
                sum += renderer.gpu_time().unwrap_or_default().as_secs_f64();
            }
            print_time(what, "the GPU computes", sum / 30.0);
        }
        print_time(what, "left in the GPU's memory", drawn);
        print_time(what, "read as bytes", shown);
        print_time(what, "read as numbers, with depths", read);

        // No pixel interpolated.
        let options =
            RenderOptions { detail: Detail { tolerances: [0.0; 4], ..options.detail }, ..options };
        for threads in [1, std::thread::available_parallelism().map_or(1, usize::from)] {
            let mut expected = Vec::new();
            let cpu = time(seconds.min(2.0), || {
                expected = on_cpu(model, &camera, &options, threads)?;
                Ok(())
            })?;
            print_time(what, &format!("{threads} threads of the CPU"), cpu);
            let squares = expected.iter().zip(&picture.rgba).map(|(a, b)| f64::from(a - b).powi(2));
            let psnr = -10.0 * (squares.sum::<f64>() / expected.len() as f64).log10();
            println!("{what}: the pictures differ by {psnr:.1} dB");
        }
    }
    Ok(())
}

fn print_time(what: &str, how: &str, seconds: f64) {
    let (ms, rate) = (1e3 * seconds, 1.0 / seconds);
    println!("{what}: {ms:8.3} ms a picture, {rate:7.1} a second: {how}");
}

/// Seconds that a picture takes, after a few of them.
fn time(seconds: f64, mut picture: impl FnMut() -> Result<(), Failure>) -> Result<f64, Failure> {
    for _ in 0..3 {
        picture()?;
    }
    let begun = Instant::now();
    let mut n = 0;
    while n < 3 || begun.elapsed().as_secs_f64() < seconds {
        picture()?;
        n += 1;
    }
    Ok(begun.elapsed().as_secs_f64() / f64::from(n))
}

/// A picture, in tiles, by so many threads.
fn on_cpu(
    model: &Model<'_>,
    camera: &Camera,
    options: &RenderOptions,
    threads: usize,
) -> Result<Vec<f32>, Error> {
    let row = camera.width as usize;
    let picture = Mutex::new(vec![0.0; 4 * row * camera.height as usize]);
    let tiles = Mutex::new(Tiles::new(camera.width, camera.height));
    let work = || -> Result<(), Error> {
        let mut scratch = vec![0.0; options.scratch_len()];
        let mut rgba = vec![0.0; 4 * Tiles::MOST_PIXELS];
        loop {
            let Some(tile) = tiles.lock().ok().and_then(|mut tiles| tiles.next()) else {
                return Ok(());
            };
            let rgba = &mut rgba[..4 * tile.pixels()];
            render_tile(model, camera, tile, options, &mut scratch, rgba, None)?;
            let Ok(mut picture) = picture.lock() else { return Ok(()) };
            for (y, pixels) in rgba.chunks_exact(4 * tile.width as usize).enumerate() {
                let first = (tile.y as usize + y) * row + tile.x as usize;
                picture[4 * first..][..pixels.len()].copy_from_slice(pixels);
            }
        }
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().unwrap_or(Ok(())))
    })?;
    Ok(picture.into_inner().unwrap_or_default())
}
