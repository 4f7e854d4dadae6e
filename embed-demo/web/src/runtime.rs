//! A small allocator and panic handler: those of the standard library would take 20 kB.
#![allow(unsafe_code, reason = "an allocator cannot be written without; each block says why")]

use core::alloc::{GlobalAlloc, Layout};
use core::arch::wasm32;
use core::cell::{Cell, RefCell};
use core::panic::PanicInfo;
use core::ptr;

#[cfg(target_feature = "atomics")]
compile_error!("the allocator is for one thread: build without atomics");

/// A variable of the only thread.
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

/// Allocates one block after another, and frees only the last one: an instance keeps a file and
/// the memory of its pictures until it is dropped, and otherwise only the last message.
struct Stack {
    /// Start of free memory; 0 before the first allocation.
    free: Cell<usize>,
}

// SAFETY: without atomics an instance has one thread.
unsafe impl Sync for Stack {}

#[global_allocator]
static STACK: Stack = Stack { free: Cell::new(0) };

impl Stack {
    /// Moves the end of used memory, if there is enough.
    fn reach(&self, end: usize) -> bool {
        let missing = end.saturating_sub(wasm32::memory_size(0) * PAGE);
        let is_enough =
            missing == 0 || wasm32::memory_grow(0, missing.div_ceil(PAGE)) != usize::MAX;
        if is_enough {
            self.free.set(end);
        }
        is_enough
    }
}

// SAFETY: blocks lie after everything that the linker placed, do not overlap, and are aligned
// as requested.
unsafe impl GlobalAlloc for Stack {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if self.free.get() == 0 {
            // Memory after the first pages is unused.
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
            // SAFETY: both blocks hold this many bytes, and do not overlap.
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
