//! The cost of vanilla NeRF's network, 8 layers of 256: evaluated as in rendering, and
//! forwards and backwards as in a training step.

use std::time::{Duration, Instant};

use fearless_simd::Level;
use pocketnerf_core::march::{Output, SampleBatch, evaluate};
use pocketnerf_core::network::panel_len;
use pocketnerf_core::scratch::{Tuning, Workspace};
use pocketnerf_core::{AnyField, Display, Model, Sampling, SimdLevel, Space};
use pocketnerf_formats::{About, Precision, open_verified, write};
use pocketnerf_train::aligned::Aligned;
use pocketnerf_train::field::{Context, SampleGradients, TrainableField, networks};
use pocketnerf_train::random::Random;
use pocketnerf_train::trainer::TrainConfig;

use super::BenchError;
use super::stage::{Crowd, Demand, Measured, StageCost, stages};
use crate::machine::Machine;

/// Samples of a batch.
const BATCH: usize = Tuning::FAST.samples;
/// Samples of each thread.
const SAMPLES: usize = 4096;
/// Rounds, of which the fastest counts: disturbances only slow down.
const ROUNDS: usize = 5;
/// Density and colour of a sample.
const ROW: usize = 4;

/// Coordinates of a batch: points and directions.
struct Inputs([Vec<f32>; 6]);

impl Inputs {
    fn new() -> Self {
        let mut random = Random::new(0, [9; 3]);
        Self(std::array::from_fn(|_| (0..BATCH).map(|_| random.next_f32()).collect()))
    }

    /// Evaluates the field at all samples.
    fn forward(&self, level: Level, field: &AnyField<'_>) {
        let (limits, stride) = (field.limits(), Tuning::FAST.stride());
        let rows = |n: usize| Aligned::new(n * stride);
        let [mut a, mut b] = limits.rows.map(rows);
        let (mut output, mut panel) = (rows(ROW), Aligned::new(panel_len(limits.width)));
        let (a, b, output, panel) = (&mut a[..], &mut b[..], &mut output[..], &mut panel[..]);
        let mut work = Workspace { a, b, output, panel, stride, rounded: false };
        let mut axes = self.0.clone();
        let [x, y, z, dx, dy, dz] = axes.each_mut().map(|axis| &mut axis[..]);
        let (points, directions) = ([x, y, z], [dx, dy, dz]);
        let mut samples = SampleBatch {
            points,
            directions,
            t: &mut [],
            capacity: BATCH,
            len: BATCH,
            directed: true,
        };
        for _ in 0..SAMPLES / BATCH {
            evaluate(level, field, Output::Channels, &mut samples, &mut work, |_, _| ());
            std::hint::black_box(&work.output);
        }
    }

    /// Forwards and backwards at all samples, as a training step does for a group of rays.
    fn both_ways(&self, field: &dyn TrainableField, group: usize, context: Context<'_>) {
        let [x, y, z, dx, dy, dz] = self.0.each_ref().map(|axis| &axis[..]);
        let mut back = field.back(group, context);
        for _ in 0..SAMPLES / BATCH {
            back.samples(&SampleGradients {
                len: BATCH,
                points: [x, y, z],
                directions: [dx, dy, dz],
                sigma: &[1.0; BATCH],
                colors: [&[0.5; BATCH]; 3],
                gradients: &[1e-3; BATCH * ROW],
                row_len: ROW,
            });
        }
    }
}

/// Thread seconds of the fastest of a few rounds, on all threads at once.
fn fastest(threads: usize, run: impl Fn(usize) + Sync) -> f64 {
    let round = |_| {
        let begun = Instant::now();
        rayon::broadcast(|thread| run(thread.index()));
        begun.elapsed()
    };
    let best = (0..ROUNDS).map(round).min().unwrap_or(Duration::MAX);
    best.as_secs_f64() * threads as f64
}

/// Measures both, beside the peak.
///
/// # Errors
/// If the machine lacks the SIMD level.
pub fn measure(simd: SimdLevel, machine: &Machine) -> Result<Vec<StageCost>, BenchError> {
    let level = simd.token()?;
    let mut field = TrainConfig::nerf().field.kind().build(1.0);
    let mut parameters = vec![0.0; field.layout().len()];
    field.initialize(0, &mut parameters);
    field.set(level, &parameters);
    field.prepare(&parameters, machine.threads);
    let (field, full) = (&*field, field.view(&parameters)?);
    let network = networks(&full).expect("a field of networks").fine;
    // Rendering reads half precision.
    let bytes = write(&model(full), &About::default(), Precision::F16)?;
    let file = open_verified(&bytes)?;
    let inputs = Inputs::new();
    let forward = fastest(machine.threads, |_| {
        inputs.forward(level, &file.model.field);
    });
    let context = Context { level, parameters: &parameters, stopwatch: None };
    let both = fastest(machine.threads, |thread| inputs.both_ways(field, thread, context));
    let [all, unread] = [network.multiply_adds, network.multiply_adds_of_inputs].map(|n| n as f64);
    let units = (SAMPLES * machine.threads) as u64;
    let cost = |name, seconds, multiply_adds: f64| {
        let demand = Demand::fma(2.0 * multiply_adds);
        let measured = Measured { name, unit: "sample", units, seconds, demand };
        stages(&[measured], seconds, units, machine, Crowd::All).swap_remove(0)
    };
    // Backwards, a layer takes as much again for its weights and for its inputs.
    let both = cost("8x256 both ways", both, 3.0 * all - unread);
    Ok(vec![cost("8x256 forward", forward, all), both])
}

/// The field within a unit box.
fn model(field: AnyField<'_>) -> Model<'_> {
    Model {
        field,
        space: Space::Box { min: [0.0; 3], max: [1.0; 3] },
        occupancy: None,
        sampling: Sampling { step: 1e-2, near: 0.0, far: 2.0, min_transmittance: 0.0 },
        hierarchical: None,
        display: Display::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_are_timed() {
        let simd = SimdLevel::detect();
        let machine = Machine::measure(simd, true).unwrap();
        let costs = measure(simd, &machine).unwrap();
        let flops = |cost: &StageCost| cost.gflops.unwrap() * cost.ns_per_unit.unwrap();
        // Multiplications and additions by hand: see the networks' report.
        let [forward, both] = [&costs[0], &costs[1]].map(flops);
        assert!((forward - 2.0 * 593_408.0).abs() < 1.0, "{forward}");
        assert!((both - (3.0 * forward - 2.0 * 35_712.0)).abs() < 1.0, "{both}");
    }
}
