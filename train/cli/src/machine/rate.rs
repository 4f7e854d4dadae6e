//! Work per second, of one thread and of all.

use std::time::{Duration, Instant};

use serde::Serialize;

/// Work per second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Of one thread while the others are idle.
    pub one_thread: f64,
    /// Of all threads together.
    pub all: f64,
}

impl Rate {
    /// The better of two measurements: disturbances only slow down.
    pub(super) const fn best(self, other: Self) -> Self {
        Self { one_thread: self.one_thread.max(other.one_thread), all: self.all.max(other.all) }
    }
}

/// How long one measurement takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span(pub(super) Duration);

impl Span {
    /// Calls `run` with the thread's number over and over; each call does `work`.
    pub(super) fn rate(self, work: f64, run: impl Fn(usize) + Sync) -> Rate {
        Rate { one_thread: self.one_thread(work, || run(0)), all: self.all(work, run) }
    }

    /// The same on one thread alone.
    pub(super) fn one_thread(self, work: f64, run: impl Fn()) -> f64 {
        let begun = Instant::now();
        self.calls(run) * work / begun.elapsed().as_secs_f64()
    }

    /// The same on all threads at once, until the last has finished.
    pub(super) fn all(self, work: f64, run: impl Fn(usize) + Sync) -> f64 {
        let begun = Instant::now();
        let calls = rayon::broadcast(|thread| self.calls(|| run(thread.index())));
        calls.iter().sum::<f64>() * work / begun.elapsed().as_secs_f64()
    }

    /// Calls `run` until the time is over and returns the number of calls.
    fn calls(self, run: impl Fn()) -> f64 {
        let begun = Instant::now();
        let mut calls = 0.0;
        while begun.elapsed() < self.0 {
            run();
            calls += 1.0;
        }
        calls
    }
}
