//! What a picture takes: instructions, and RAM. The only unsafe code of the program.

use core::ptr::{addr_of, read_volatile};

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Of QEMU with `-icount shift=0`: an instruction takes a nanosecond, a tick of this
/// machine's 25 MHz forty of them.
const INSTRUCTIONS_PER_TICK: u32 = 40;
const TICKS: u32 = 0x00ff_ffff;
/// What `cortex-m-rt` paints the stack with.
const PAINT: u32 = 0xcccc_cccc;

unsafe extern "C" {
    // Of cortex-m-rt's linker script: where RAM's variables begin and end, and where the stack
    // begins, growing downwards.
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

    /// Notes that a part is over. Parts must be shorter than the clock's round, 0.67 s.
    pub(crate) fn line(&mut self) {
        if self.clock.is_some() {
            let now = SYST::get_current();
            self.ticks += self.last.wrapping_sub(now) & TICKS;
            self.last = now;
        }
    }

    /// Notes that the model is open.
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

    /// Bytes of stack that opening has used.
    pub(crate) const fn stack_to_open(&self) -> u32 {
        self.stack_to_open
    }

    /// Bytes of variables.
    pub(crate) fn static_ram(&self) -> u32 {
        (addr_of!(__sheap) as usize - addr_of!(__sdata) as usize) as u32
    }

    /// Bytes of stack that were used at any time.
    pub(crate) fn stack(&self) -> u32 {
        let (mut at, start) = (addr_of!(__sheap), addr_of!(_stack_start));
        // SAFETY: between variables and the stack's beginning lies RAM that is nobody's or the stack's;
        // it is read as it is.
        while at < start && unsafe { read_volatile(at) } == PAINT {
            at = at.wrapping_add(1);
        }
        (start as usize - at as usize) as u32
    }
}
