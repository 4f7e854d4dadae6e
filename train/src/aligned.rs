//! Buffers that begin at a cache line.
//!
//! A register of 16 values is one line, a 2×2×2 block of a hash grid's entries half
//! of one in eight bits: begun elsewhere, they would straddle two.

use std::ops::{Deref, DerefMut};

/// Bytes of a cache line.
const LINE: usize = 64;

/// A slice of fixed length on the heap, aligned to a cache line.
#[derive(Debug)]
pub struct Aligned<T> {
    memory: Vec<T>,
    start: usize,
    len: usize,
}

impl<T: Copy + Default> Aligned<T> {
    /// `len` default values.
    pub fn new(len: usize) -> Self {
        let spare = LINE / size_of::<T>();
        let memory = vec![T::default(); len + spare];
        // `align_offset` may refuse; then the buffer is merely slower.
        let start = memory.as_ptr().align_offset(LINE).min(spare);
        Self { memory, start, len }
    }
}

impl<T: Copy + Default> Clone for Aligned<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::new(self.len);
        copy.copy_from_slice(self);
        copy
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.memory[self.start..self.start + self.len]
    }
}

impl<T> DerefMut for Aligned<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.memory[self.start..self.start + self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn begins_at_a_line() {
        for len in [0, 1, 100, 4096] {
            let mut buffer = Aligned::<u16>::new(len);
            assert_eq!(buffer.len(), len);
            assert_eq!(buffer.as_ptr() as usize % LINE, 0);
            buffer.fill(7);
            let copy = buffer.clone();
            assert_eq!(*copy, *buffer);
            assert_eq!(copy.as_ptr() as usize % LINE, 0);
        }
    }
}
