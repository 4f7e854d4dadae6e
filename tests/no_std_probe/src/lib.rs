//! Opens a model file and renders a tile of it with nothing but a stack.
#![no_std]

mod model;

use core::panic::PanicInfo;

use pocketnerf_core::{
    Camera, Limits, RenderOptions, SimdLevel, Tile, Tuning, render_tile, scratch,
};
use pocketnerf_formats::FormatError;

const WIDTH: u32 = 8;
const HEIGHT: u32 = 8;
const LIMITS: Limits = Limits { width: 16, rows: [16; 2], channels: 8, ray_samples: 0 };
const SCRATCH: usize = scratch::scratch_len(LIMITS, Tuning::SMALL);

/// Renders a picture of 8 × 8 pixels into `rgba`, four values each; gives 0, or
/// 1 for a refusal.
#[unsafe(no_mangle)]
pub extern "C" fn pocketnerf_probe(rgba: &mut [f32; (4 * WIDTH * HEIGHT) as usize]) -> u32 {
    u32::from(render(rgba).is_err())
}

fn render(rgba: &mut [f32]) -> Result<(), FormatError> {
    let mut scratch = [0.0; SCRATCH];
    let model = model::open()?.model;
    let pose = Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], [0.0, 1.0, 0.0]);
    let camera = Camera::from_fov_x(WIDTH, HEIGHT, 0.8, pose);
    let mut options = RenderOptions::new(&model, SimdLevel::compiled(), Tuning::SMALL);
    options.limits = LIMITS;
    let tile = Tile { x: 0, y: 0, width: WIDTH, height: HEIGHT };
    render_tile(&model, &camera, tile, &options, &mut scratch, rgba, None)?;
    Ok(())
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}
