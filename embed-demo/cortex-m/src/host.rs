//! The way out, where a debugger or QEMU listens: semihosting.

use core::fmt::Write;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hio;
use pocketnerf_core::render::RenderStats;

use crate::display::{Display, SIDE};
use crate::meter::Meter;

/// The display as a PPM picture on standard output.
pub(crate) fn show(display: &Display) {
    let Ok(mut out) = hio::hstdout() else { return };
    let _ = writeln!(out, "P6 {SIDE} {SIDE} 255");
    let _ = out.write_all(display.bytes());
}

/// What it took, on standard error.
pub(crate) fn tell(stats: &RenderStats, meter: &Meter) {
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

/// Ends the program under QEMU; on a board without a debugger it would go on to show the display.
pub(crate) fn exit() -> ! {
    loop {
        debug::exit(EXIT_SUCCESS);
    }
}

/// The same where something went wrong that should not.
pub(crate) fn fail() -> ! {
    loop {
        debug::exit(EXIT_FAILURE);
    }
}
