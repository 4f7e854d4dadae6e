//! Buffers that threads take and give back, so that as many exist as there are
//! threads, whatever the number of tasks.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// A heap of interchangeable buffers.
#[derive(Debug)]
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> Pool<T> {
    /// An unused buffer, or a new one.
    pub(crate) fn take(&self, new: impl FnOnce() -> T) -> T {
        let free = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        free.unwrap_or_else(new)
    }

    /// As [`take`](Self::take); it is given back when the lease ends.
    pub(crate) fn lease(&self, new: impl FnOnce() -> T) -> Lease<'_, T> {
        Lease { pool: self, buffer: Some(self.take(new)) }
    }

    /// Gives a buffer back.
    pub(crate) fn put(&self, buffer: T) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(buffer);
    }
}

/// A buffer on loan.
#[derive(Debug)]
pub(crate) struct Lease<'p, T> {
    pool: &'p Pool<T>,
    /// There until it is dropped.
    buffer: Option<T>,
}

impl<T> Deref for Lease<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.buffer.as_ref().expect("there until it is dropped")
    }
}

impl<T> DerefMut for Lease<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.buffer.as_mut().expect("there until it is dropped")
    }
}

impl<T> Drop for Lease<'_, T> {
    fn drop(&mut self) {
        self.buffer.take().into_iter().for_each(|buffer| self.pool.put(buffer));
    }
}

impl<T: Send> Pool<T> {
    /// Does all tasks on the threads of the current pool, each with a buffer of its own.
    /// Results are in the order of the tasks.
    ///
    /// # Errors
    /// The error of a task, which ends the others.
    pub(crate) fn map<J: Send, R: Send, E: Send>(
        &self,
        tasks: Vec<J>,
        new: impl Fn() -> T + Sync,
        work: impl Fn(&mut T, J) -> Result<R, E> + Sync,
    ) -> Result<Vec<R>, E> {
        // A bridge hands tasks out in their order: neighbouring tiles at the same time.
        let numbered = tasks.into_iter().enumerate().par_bridge();
        let done = numbered.map(|(number, task)| {
            let mut buffer = self.take(&new);
            let result = work(&mut buffer, task);
            self.put(buffer);
            Ok((number, result?))
        });
        let mut results = done.collect::<Result<Vec<_>, E>>()?;
        results.sort_unstable_by_key(|(number, _)| *number);
        Ok(results.into_iter().map(|(_, result)| result).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_and_buffers_are_shared() {
        let pool = Pool::default();
        let double = |count: &mut u32, task: u32| {
            *count += 1;
            if task < 100 { Ok(2 * task) } else { Err(task) }
        };
        let results = pool.map((0..100).collect(), || 0, double).unwrap();
        assert_eq!(results, (0..100).map(|task| 2 * task).collect::<Vec<_>>());
        let counts = pool.0.into_inner().unwrap();
        assert!(counts.len() <= rayon::current_num_threads());
        assert_eq!(counts.iter().sum::<u32>(), 100);
        let failed = Pool::default().map((0..101).collect(), || 0, double);
        assert_eq!(failed, Err(100));
    }
}
