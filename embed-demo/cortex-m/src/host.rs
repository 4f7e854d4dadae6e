//! Output by semihosting, to a debugger or QEMU.

use core::fmt::Write;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hio;
use pocketnerf_core::render::RenderStats;

use crate::display::{Display, SIDE};
use crate::meter::Meter;

/// Writes the display as a PPM picture to standard output.
pub(crate) fn show(display: &Display) {
    let Ok(mut out) = hio::hstdout() else { return };
    let _ = writeln!(out, "P6 {SIDE} {SIDE} 255");
    let _ = out.write_all(display.bytes());
}

/// Writes statistics to standard error.
pub(crate) fn report(stats: &RenderStats, meter: &Meter) {
    let Ok(mut out) = hio::hstderr() else { return };
    for (name, value) in [
        ("samples", stats.samples as u32),
        ("rays", stats.rays as u32),
        ("instructions_to_open", meter.to_open()),
        ("instructions_to_render", meter.to_render()),
        ("stack_to_open", meter.stack_to_open()),
        ("static_ram", meter.static_ram()),
        ("stack", meter.stack()),
    ] {
        let _ = writeln!(out, "{name} {value}");
    }
}

/// Ends the program under QEMU; a board without a debugger keeps showing the display.
pub(crate) fn exit() -> ! {
    loop {
        debug::exit(EXIT_SUCCESS);
    }
}

/// The same after a panic.
pub(crate) fn fail() -> ! {
    loop {
        debug::exit(EXIT_FAILURE);
    }
}
