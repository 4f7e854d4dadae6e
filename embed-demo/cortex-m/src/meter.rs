//! Counts instructions and RAM. The only unsafe code of the program.

use core::ptr::{addr_of, read_volatile};

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// In QEMU with `-icount shift=0` an instruction takes a nanosecond, and a tick of the 25 MHz
/// clock forty of them.
const INSTRUCTIONS_PER_TICK: u32 = 40;
const TICKS: u32 = 0x00ff_ffff;
/// `cortex-m-rt` fills the unused stack with this.
const PAINT: u32 = 0xcccc_cccc;

unsafe extern "C" {
    // From cortex-m-rt's linker script: start and end of variables in RAM, and the start of the
    // stack, which grows downwards.
    static __sdata: u32;
    static __sheap: u32;
    static _stack_start: u32;
}

pub(crate) struct Meter {
    clock: Option<SYST>,
    last: u32,
    ticks: u32,
    ticks_to_open: u32,
    stack_to_open: u32,
}

impl Meter {
    pub(crate) fn start() -> Self {
        let mut clock = Peripherals::take().map(|peripherals| peripherals.SYST);
        if let Some(clock) = &mut clock {
            clock.set_clock_source(SystClkSource::Core);
            clock.set_reload(TICKS);
            clock.clear_current();
            clock.enable_counter();
        }
        Self { clock, last: SYST::get_current(), ticks: 0, ticks_to_open: 0, stack_to_open: 0 }
    }

    /// Counts the time since the last call, which must be shorter than a wrap of the clock, 0.67 s.
    pub(crate) fn line(&mut self) {
        if self.clock.is_some() {
            let now = SYST::get_current();
            self.ticks += self.last.wrapping_sub(now) & TICKS;
            self.last = now;
        }
    }

    /// To be called when the model is open.
    pub(crate) fn opened(&mut self) {
        self.line();
        self.ticks_to_open = self.ticks;
        self.stack_to_open = self.stack();
    }

    pub(crate) const fn to_open(&self) -> u32 {
        self.ticks_to_open.saturating_mul(INSTRUCTIONS_PER_TICK)
    }

    pub(crate) const fn to_render(&self) -> u32 {
        (self.ticks - self.ticks_to_open).saturating_mul(INSTRUCTIONS_PER_TICK)
    }

    /// Bytes of stack used for opening.
    pub(crate) const fn stack_to_open(&self) -> u32 {
        self.stack_to_open
    }

    /// Bytes of variables.
    pub(crate) fn static_ram(&self) -> u32 {
        (addr_of!(__sheap) as usize - addr_of!(__sdata) as usize) as u32
    }

    /// The most bytes of stack used so far.
    pub(crate) fn stack(&self) -> u32 {
        let (mut at, start) = (addr_of!(__sheap), addr_of!(_stack_start));
        // SAFETY: between the variables and the start of the stack lies RAM that is unused or part of
        // the stack; it is only read.
        while at < start && unsafe { read_volatile(at) } == PAINT {
            at = at.wrapping_add(1);
        }
        (start as usize - at as usize) as u32
    }
}
