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
    /// The clock of one core.
    pub clock_ghz: f64,
    /// The same at the end; if it is lower, fractions are too low by as much.
    pub clock_ghz_at_end: f64,
    /// Multiplications and additions of `f32` values in registers, 10^9 per second,
    /// all threads.
    pub peak_gflops: f64,
    /// The same on one thread.
    pub peak_gflops_one_thread: f64,
    /// The share of two fused multiply-adds per cycle that one thread reaches.
    pub fma_fraction: f64,
    /// Sequential reading beyond all caches, 10^9 bytes per second, all threads.
    pub peak_gb_per_s: f64,
    /// The same on one thread.
    pub peak_gb_per_s_one_thread: f64,
    /// Sequential reading of buffers of several sizes.
    pub streams: Vec<Stream>,
    /// Random reads of eight bytes from tables of several sizes.
    pub gathers: Vec<Gather>,
    /// The cost of vanilla NeRF's network.
    pub networks: Vec<StageCost>,
    /// Dataset that training was timed on.
    pub dataset: String,
    /// The cost of a training step.
    pub training: Training,
    /// Model that was rendered.
    pub model: String,
    /// The cost of a picture.
    pub rendering: Rendering,
}

/// Sequential reading.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Stream {
    /// Size of the buffer.
    pub bytes: usize,
    /// 10^9 bytes per second.
    pub gb_per_s_one_thread: f64,
    /// All threads together, each with its part of the buffer.
    pub gb_per_s_all: f64,
}

/// Random reads.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Gather {
    /// Size of the table.
    pub bytes: usize,
    /// Reads per second.
    pub per_second_one_thread: f64,
    /// All threads together, in one table.
    pub per_second_all: f64,
}

impl Report {
    /// Puts the parts together; `dataset` and `model` come with their names, `clock_at_end` is
    /// in cycles per second.
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
