//! What the C interface costs: frames through it and through the Rust crates, by turns.
//!
//! ```sh
//! cargo run --release -p pocketnerf-c --example overhead -- [MODEL [SIDE [ROUNDS]]]
//! ```
//! Both render the file's own view, square, on one thread, to bytes over the background.

use std::error::Error;
use std::ffi::CString;
use std::ptr::{null, null_mut};
use std::time::Instant;

use pocketnerf_c::{
    Camera, Image, Info, Status, pnrf_close, pnrf_default_camera, pnrf_info, pnrf_open_file,
    pnrf_render, pnrf_scratch_length, pnrf_sphere_clear,
};
use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Camera as CoreCamera, Model, RenderOptions, SimdLevel, Tuning, render_tile};

const STILL_LIFE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../still-life.pnerf");

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().unwrap_or_else(|| STILL_LIFE.to_owned());
    let side: u32 = arguments.next().map_or(Ok(400), |n| n.parse())?;
    let rounds: usize = arguments.next().map_or(Ok(31), |n| n.parse())?;

    let bytes = std::fs::read(&path)?;
    let bytes = pocketnerf_formats::unpacked(&bytes)?;
    let file = pocketnerf_formats::open_verified(&bytes)?;
    let mut table = vec![0; file.model.table_len()];
    let model = file.model.with_table(&mut table)?;
    let quality = file.about.quality.unwrap_or(0.5);

    let name = CString::new(path)?;
    let mut opened = null_mut();
    // SAFETY: numbers may be zero.
    let (mut camera, mut info): (Camera, Info) = unsafe { std::mem::zeroed() };
    let mut length = 0;
    // SAFETY: places of ours.
    unsafe {
        expect(pnrf_open_file(name.as_ptr(), 0, &raw mut opened, null_mut()));
        expect(pnrf_default_camera(opened, side, side, &raw mut camera, null_mut()));
        expect(pnrf_info(opened, &raw mut info, null_mut()));
        expect(pnrf_scratch_length(opened, null(), &raw mut length, null_mut()));
    }
    let (mut scratch, mut pixels) = (vec![0.0; length], vec![0u8; 4 * (side * side) as usize]);
    let image = Image {
        pixels: pixels.as_mut_ptr().cast(),
        size: pixels.len(),
        background: model.display.background,
        // SAFETY: numbers may be zero, and pointers null.
        ..unsafe { std::mem::zeroed() }
    };
    let Camera { width, height, focal, center, camera_to_world } = camera;
    let view = CoreCamera { width, height, focal, center, camera_to_world };
    let view = file.about.scene.camera_to_model(&view);

    let (mut through_c, mut direct, mut own) = (Vec::new(), Vec::new(), vec![0; pixels.len()]);
    for _ in 0..rounds {
        let begun = Instant::now();
        let at = scratch.as_mut_ptr();
        // SAFETY: places of ours.
        expect(unsafe {
            pnrf_render(opened, &camera, null(), &image, at, length, null_mut(), null_mut())
        });
        through_c.push(begun.elapsed().as_secs_f64());
        let begun = Instant::now();
        picture(&model, &view, quality, &mut own)?;
        direct.push(begun.elapsed().as_secs_f64());
    }
    assert!(own == pixels, "other bytes");
    let ball = [info.center[0], info.center[1], info.center[2], 0.1 * info.radius];
    let (calls, mut clear) = (10_000, 0);
    let begun = Instant::now();
    for _ in 0..calls {
        // SAFETY: places of ours.
        expect(unsafe { pnrf_sphere_clear(opened, ball.as_ptr(), 1, &raw mut clear, null_mut()) });
    }
    let asked = begun.elapsed().as_secs_f64() / f64::from(calls);
    println!("a call of pnrf_sphere_clear for one ball: {:.2} microseconds", 1e6 * asked);
    // SAFETY: nobody uses it any more.
    unsafe { pnrf_close(opened) };
    let ratios: Vec<f64> = through_c.iter().zip(&direct).map(|(c, rust)| c / rust).collect();
    let [c, rust, ratio] = [through_c, direct, ratios].map(median);
    println!(
        "{side}x{side}, medians of {rounds}: {:.2} ms through C, {:.2} ms directly, ratio of neighbours {ratio:.4}",
        1e3 * c,
        1e3 * rust,
    );
    Ok(())
}

fn expect(status: Status) {
    assert_eq!(status, Status::Ok);
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A frame as a Rust program renders it.
fn picture(
    model: &Model<'_>,
    camera: &CoreCamera,
    quality: f32,
    to: &mut [u8],
) -> Result<(), pocketnerf_core::Error> {
    let options = RenderOptions {
        detail: model.detail(quality),
        ..RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST)
    };
    let (mut scratch, mut rgba) =
        (vec![0.0; options.scratch_len()], vec![0.0; 4 * Tiles::MOST_PIXELS]);
    for tile in Tiles::new(camera.width, camera.height) {
        let rgba = &mut rgba[..4 * tile.pixels()];
        render_tile(model, camera, tile, &options, &mut scratch, rgba, None)?;
        let rows = rgba.as_chunks::<4>().0.chunks(tile.width as usize);
        for (y, row) in (tile.y..).zip(rows) {
            let at = 4 * (y * camera.width + tile.x) as usize;
            for (to, rgba) in to[at..].as_chunks_mut::<4>().0.iter_mut().zip(row) {
                let [r, g, b] = model.display.rgb8(*rgba);
                *to = [r, g, b, 255];
            }
        }
    }
    Ok(())
}
