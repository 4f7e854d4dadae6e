//! Work a second, of one thread and of all.

use std::time::{Duration, Instant};

use serde::Serialize;

/// How thoroughly something is measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// How long one repetition takes.
    span: Duration,
    /// Repetitions; the best counts: whatever disturbs makes slower.
    repetitions: usize,
}

/// Work a second, of whatever kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Of one thread while the others rest.
    pub one_thread: f64,
    /// Of all threads together.
    pub all: f64,
}

impl Effort {
    pub(super) const fn of(quick: bool) -> Self {
        let (span, repetitions) = if quick { (2, 2) } else { (20, 5) };
        Self { span: Duration::from_millis(span), repetitions }
    }

    /// Calls `run` with the thread's number over and over; each call does `work`.
    pub(super) fn rate(&self, work: f64, run: impl Fn(usize) + Sync) -> Rate {
        Rate { one_thread: self.one_thread(work, || run(0)), all: self.all(work, run) }
    }

    /// The same on one thread alone.
    pub(super) fn one_thread(&self, work: f64, run: impl Fn()) -> f64 {
        let once = || {
            let begun = Instant::now();
            self.calls(&run) * work / begun.elapsed().as_secs_f64()
        };
        (0..self.repetitions).map(|_| once()).fold(0.0, f64::max)
    }

    /// The same on all threads at once, until the last has finished.
    pub(super) fn all(&self, work: f64, run: impl Fn(usize) + Sync) -> f64 {
        let once = || {
            let begun = Instant::now();
            let calls = rayon::broadcast(|thread| self.calls(|| run(thread.index())));
            calls.iter().sum::<f64>() * work / begun.elapsed().as_secs_f64()
        };
        (0..self.repetitions).map(|_| once()).fold(0.0, f64::max)
    }

    /// Calls `run` until the time is over; gives the number of calls.
    fn calls(&self, run: impl Fn()) -> f64 {
        let begun = Instant::now();
        let mut calls = 0.0;
        while begun.elapsed() < self.span {
            run();
            calls += 1.0;
        }
        calls
    }
}
