//! Buffers that threads take and give back, so that as many exist as there are
//! threads, whatever the number of tasks.

use std::sync::{Mutex, PoisonError};

/// A heap of interchangeable buffers.
#[derive(Debug)]
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> Pool<T> {
    /// A buffer that nobody uses, or a new one.
    pub(crate) fn take(&self, new: impl FnOnce() -> T) -> T {
        let free = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        free.unwrap_or_else(new)
    }

    /// Gives a buffer back.
    pub(crate) fn put(&self, buffer: T) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(buffer);
    }
}
