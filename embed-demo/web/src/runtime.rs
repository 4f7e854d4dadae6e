//! What stands in for a standard library, whose allocator and panics would take 20 kB.
#![allow(unsafe_code, reason = "an allocator cannot be written without; each block says why")]

use core::alloc::{GlobalAlloc, Layout};
use core::arch::wasm32;
use core::cell::{Cell, RefCell};
use core::panic::PanicInfo;
use core::ptr;

#[cfg(target_feature = "atomics")]
compile_error!("this is for instances with memory of their own, and one thread");

/// A variable of the one thread.
pub(crate) struct Single<T>(RefCell<T>);

// SAFETY: without atomics an instance has one thread.
unsafe impl<T> Sync for Single<T> {}

impl<T> Single<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self(RefCell::new(value))
    }

    pub(crate) fn with_borrow_mut<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        work(&mut self.0.borrow_mut())
    }
}

const PAGE: usize = 1 << 16;

/// Hands out new memory, one block after another, and takes back the last one alone: an
/// instance holds a file and what its pictures need until it goes, and beside that the text of
/// the last message.
struct Stack {
    /// Where free memory begins; 0: nobody has asked yet.
    free: Cell<usize>,
}

// SAFETY: without atomics an instance has one thread.
unsafe impl Sync for Stack {}

#[global_allocator]
static STACK: Stack = Stack { free: Cell::new(0) };

impl Stack {
    /// Moves the end of what is used, if there is so much memory.
    fn reach(&self, end: usize) -> bool {
        let missing = end.saturating_sub(wasm32::memory_size(0) * PAGE);
        let is_there = missing == 0 || wasm32::memory_grow(0, missing.div_ceil(PAGE)) != usize::MAX;
        if is_there {
            self.free.set(end);
        }
        is_there
    }
}

// SAFETY: blocks lie behind all that the linker placed, none overlaps another, and each is
// aligned as asked.
unsafe impl GlobalAlloc for Stack {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if self.free.get() == 0 {
            // Memory behind the first pages is nobody's.
            self.free.set(wasm32::memory_size(0) * PAGE);
        }
        let end = (self.free.get().checked_next_multiple_of(layout.align()))
            .and_then(|start| Some((start, start.checked_add(layout.size())?)));
        match end {
            Some((start, end)) if self.reach(end) => ptr::with_exposed_provenance_mut(start),
            _ => ptr::null_mut(),
        }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        if block.addr() + layout.size() == self.free.get() {
            self.free.set(block.addr());
        }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let is_last = block.addr() + layout.size() == self.free.get();
        if let (true, Some(end)) = (is_last, block.addr().checked_add(size)) {
            return if self.reach(end) { block } else { ptr::null_mut() };
        }
        // SAFETY: the caller's promise, that size and alignment make a layout.
        let new = unsafe { self.alloc(Layout::from_size_align_unchecked(size, layout.align())) };
        if !new.is_null() {
            // SAFETY: both blocks hold so much, and are two.
            unsafe { ptr::copy_nonoverlapping(block, new, size.min(layout.size())) };
        }
        new
    }
}

/// Ends the instance: the page sees a `RuntimeError`.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    wasm32::unreachable()
}
