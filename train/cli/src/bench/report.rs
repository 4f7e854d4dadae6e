//! Everything that was measured, as it is printed.

use serde::Serialize;

use super::{Rendering, StageCost, Training};
use crate::machine::{Curve, Machine};

/// Everything that was measured: the object that `bench --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Vector instructions.
    pub simd: &'static str,
    /// Threads.
    pub threads: usize,
    /// The clock that one core runs at.
    pub clock_ghz: f64,
    /// The same when everything was done: as far below, fractions are too low.
    pub clock_ghz_at_end: f64,
    /// Multiplications and additions of `f32` values in registers, 10^9 a second,
    /// all threads.
    pub peak_gflops: f64,
    /// The same on one thread.
    pub peak_gflops_one_thread: f64,
    /// What one thread reaches of two fused multiply-adds a cycle.
    pub fma_fraction: f64,
    /// Memory that no cache holds, read from its beginning to its end, 10^9 bytes a
    /// second, all threads.
    pub peak_gb_per_s: f64,
    /// The same on one thread.
    pub peak_gb_per_s_one_thread: f64,
    /// Buffers of several sizes, read from their beginning to their end.
    pub streams: Vec<Stream>,
    /// Tables of several sizes, eight bytes read at random places.
    pub gathers: Vec<Gather>,
    /// What the paper's network costs.
    pub networks: Vec<StageCost>,
    /// Dataset that training was timed on.
    pub dataset: String,
    /// What a training step costs.
    pub training: Training,
    /// Model that was rendered.
    pub model: String,
    /// What a picture costs.
    pub rendering: Rendering,
}

/// Reading from the beginning to the end.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Stream {
    /// Size of the buffer.
    pub bytes: usize,
    /// 10^9 bytes a second.
    pub gb_per_s_one_thread: f64,
    /// All threads together, each with its part of the buffer.
    pub gb_per_s_all: f64,
}

/// Reading at random places.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Gather {
    /// Size of the table.
    pub bytes: usize,
    /// Reads a second.
    pub per_second_one_thread: f64,
    /// All threads together, in one table.
    pub per_second_all: f64,
}

impl Report {
    /// Puts the parts together; `dataset` and `model` are what people call them,
    /// `clock_at_end` is in cycles a second.
    #[must_use]
    pub fn new(
        machine: &Machine,
        networks: Vec<StageCost>,
        (dataset, training): (String, Training),
        (model, rendering): (String, Rendering),
        clock_at_end: f64,
    ) -> Self {
        let memory = machine.streams.at(f64::INFINITY);
        Self {
            simd: machine.simd.name(),
            threads: machine.threads,
            clock_ghz: machine.clock * 1e-9,
            clock_ghz_at_end: clock_at_end * 1e-9,
            peak_gflops: machine.flops.all * 1e-9,
            peak_gflops_one_thread: machine.flops.one_thread * 1e-9,
            fma_fraction: machine.fma_fraction,
            peak_gb_per_s: memory.all * 1e-9,
            peak_gb_per_s_one_thread: memory.one_thread * 1e-9,
            streams: streams(&machine.streams),
            gathers: gathers(&machine.gathers),
            networks,
            dataset,
            training,
            model,
            rendering,
        }
    }
}

fn streams(curve: &Curve) -> Vec<Stream> {
    let stream = |point: &crate::machine::Point| Stream {
        bytes: point.bytes,
        gb_per_s_one_thread: point.rate.one_thread * 1e-9,
        gb_per_s_all: point.rate.all * 1e-9,
    };
    curve.0.iter().map(stream).collect()
}

fn gathers(curve: &Curve) -> Vec<Gather> {
    let gather = |point: &crate::machine::Point| Gather {
        bytes: point.bytes,
        per_second_one_thread: point.rate.one_thread,
        per_second_all: point.rate.all,
    };
    curve.0.iter().map(gather).collect()
}
