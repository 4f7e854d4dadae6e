//! A radiance field on a bare microcontroller: no operating system, no heap, 64 KB of RAM.
//!
//! The model is read in place, from flash. All memory is allocated at compile time: scratch for
//! every hash grid with networks up to 64 wide, a display of 64 x 64 pixels and a line of it. The
//! display shows an error for a model that needs more, or a file that is not a model.
//!
//! Under QEMU, semihosting writes the display to standard output as a PPM picture, and statistics
//! to standard error; see `run` beside this crate.
#![no_std]
#![no_main]

mod display;
mod host;
mod meter;

use core::panic::PanicInfo;

use cortex_m_rt::entry;
use pocketnerf_core::render::{Detail, RenderStats};
use pocketnerf_core::scratch::scratch_len;
use pocketnerf_core::{Camera, Limits, Model, RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use pocketnerf_formats::FormatError;

use display::{Display, SIDE};
use meter::Meter;

/// Limits of the models that there is memory for.
const LIMITS: Limits = if cfg!(feature = "less-memory") {
    Limits { width: 16, rows: [16; 2], channels: 8, ray_samples: 0 }
} else {
    Limits::SMALL
};
const SCRATCH: usize = scratch_len(LIMITS, Tuning::SMALL);

// In its own section, so the size of the code is measured without it.
#[unsafe(link_section = ".model")]
static MODEL: [u8; include_bytes!(concat!(env!("OUT_DIR"), "/model.pnerf")).len()] =
    *include_bytes!(concat!(env!("OUT_DIR"), "/model.pnerf"));

#[entry]
fn main() -> ! {
    static mut DISPLAY: Display = Display::new();
    static mut SCRATCH_MEMORY: [f32; SCRATCH] = [0.0; SCRATCH];
    let mut meter = Meter::start();
    let shown = picture(DISPLAY, SCRATCH_MEMORY, &mut meter);
    if let Err(wrong) = &shown {
        DISPLAY.say(wrong.text());
    }
    host::show(DISPLAY);
    host::report(&shown.unwrap_or_default(), &meter);
    host::exit()
}

/// Opens the model and renders its own view, line by line.
fn picture(
    display: &mut Display,
    scratch: &mut [f32],
    meter: &mut Meter,
) -> Result<RenderStats, Wrong> {
    // Not a constant to the optimiser, which would otherwise read it while compiling.
    let file = pocketnerf_formats::open(core::hint::black_box(&MODEL)).map_err(Wrong::File)?;
    meter.opened();
    let model = &file.model;
    let camera = match file.about.camera {
        Some(own) => Camera::from_fov_x(SIDE, SIDE, own.fov_x, own.camera_to_world),
        None => return Err(Wrong::NoCamera),
    };
    let options = options(model);
    let mut stats = RenderStats::default();
    for y in 0..SIDE {
        let mut line = [0.0; 4 * SIDE as usize];
        let tile = Tile { x: 0, y, width: SIDE, height: 1 };
        stats += render_tile(model, &camera, tile, &options, scratch, &mut line, None)
            .map_err(Wrong::Model)?;
        display.line(y, line.as_chunks().0, &model.display);
        meter.line();
    }
    Ok(stats)
}

fn options(model: &Model<'_>) -> RenderOptions {
    let options = RenderOptions::new(model, SimdLevel::compiled(), Tuning::SMALL);
    // A single line has no neighbours to interpolate from.
    RenderOptions { limits: LIMITS, detail: Detail::FINEST, ..options }
}

/// Why there is no picture.
enum Wrong {
    File(FormatError),
    Model(pocketnerf_core::Error),
    NoCamera,
}

impl Wrong {
    /// A text that fits on the display: core's messages would cost kilobytes.
    fn text(&self) -> &'static str {
        use pocketnerf_core::Error;
        match self {
            Self::File(FormatError::NotPnerf { .. }) => "not a model",
            Self::File(FormatError::FieldKind(_)) => "kind of field\nnot linked",
            Self::File(FormatError::Version { .. }) => "another version",
            Self::File(_) => "damaged model",
            Self::Model(Error::Limits(_)) => "model needs\nmore memory",
            Self::Model(_) => "cannot render",
            Self::NoCamera => "no view in\nthe model",
        }
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    host::fail()
}
