//! What the paper's network costs, 8 layers of 256: asked as rendering asks it, and
//! forwards and backwards as a training step goes.

use std::time::{Duration, Instant};

use fearless_simd::{Simd, dispatch};
use pocketnerf_core::field::{NerfField, Samples};
use pocketnerf_core::march::{Output, SampleBatch, evaluate};
use pocketnerf_core::network::panel_len;
use pocketnerf_core::scratch::{Tuning, Workspace};
use pocketnerf_core::{AnyField, Error, SimdLevel};
use pocketnerf_train::aligned::Aligned;
use pocketnerf_train::field::nerf::{NerfGradients, NerfTape};
use pocketnerf_train::field::{FieldKind, Layout, NerfConfig, Rounded};
use pocketnerf_train::random::Random;

use super::stage::{Crowd, Demand, Measured, StageCost, stages};
use crate::machine::Machine;

/// Samples of a batch, as in rendering.
const BATCH: usize = Tuning::FAST.samples;
/// Samples that go forwards and back together, as in training.
const TOGETHER: usize = 512;
/// Samples of each thread.
const SAMPLES: usize = 4096;
/// Rounds, of which the fastest counts: whatever disturbs makes slower.
const ROUNDS: usize = 5;

/// The paper's network, rows of points and directions, and where gradients come from.
struct Setting {
    nerf: NerfConfig,
    layout: Layout,
    parameters: Vec<f32>,
    rounded: Rounded,
    gradients: NerfGradients,
    axes: [Vec<f32>; 6],
}

impl Setting {
    fn new(simd: SimdLevel) -> Result<Self, Error> {
        let nerf = NerfConfig { coarse: false, ..NerfConfig::vanilla() };
        let layout = nerf.layout();
        let mut parameters = vec![0.0; layout.len()];
        nerf.build(1.0).initialize(0, &mut parameters);
        let mut rounded = Rounded::new(&layout);
        rounded.round(simd.token()?, &layout, &parameters);
        let mut gradients = NerfGradients::new(&nerf, &layout);
        gradients.update(&parameters);
        let mut random = Random::new(0, [9; 3]);
        let axes = std::array::from_fn(|_| (0..BATCH).map(|_| random.next_f32()).collect());
        Ok(Self { nerf, layout, parameters, rounded, gradients, axes })
    }

    fn samples(&self, n: usize) -> Samples<'_> {
        let [x, y, z, dx, dy, dz] = self.axes.each_ref().map(|axis| &axis[..n]);
        Samples { points: [x, y, z], directions: [dx, dy, dz] }
    }

    /// Evaluates the field at all samples, from half-precision weights.
    fn forward<S: Simd>(&self, simd: S, field: &AnyField<'_>) {
        let (limits, stride) = (field.limits(), Tuning::FAST.stride());
        let rows = |n: usize| Aligned::new(n * stride);
        let [mut a, mut b] = limits.rows.map(rows);
        let (mut output, mut panel) = (rows(4), Aligned::new(panel_len(limits.width)));
        let (a, b, output, panel) = (&mut a[..], &mut b[..], &mut output[..], &mut panel[..]);
        let mut work = Workspace { a, b, output, panel, stride };
        let mut axes = self.axes.clone();
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
            let field = field.kernels();
            evaluate(simd, field, Output::Channels, &mut samples, &mut work, |_, _| ());
            std::hint::black_box(&work.output);
        }
    }

    /// Forwards and backwards, as training does.
    fn both_ways<S: Simd>(&self, simd: S, field: &NerfField<'_>) {
        let mut tape = NerfTape::new(&self.nerf, TOGETHER);
        let mut work = self.gradients.work(TOGETHER);
        let mut gradient = vec![0.0; self.layout.len()];
        let Samples { points, directions } = self.samples(TOGETHER);
        for _ in 0..SAMPLES / TOGETHER {
            tape.forward(simd, field, points, directions);
            for s in 0..TOGETHER {
                tape.set_gradient(s, 1e-3, [1e-3; 3]);
            }
            self.gradients.backward(simd, false, &tape, &mut work, &mut gradient);
        }
        std::hint::black_box(&gradient);
    }
}

/// Thread seconds of the fastest of a few rounds, on all threads at once.
fn fastest(threads: usize, run: impl Fn() + Sync) -> f64 {
    let round = |_| {
        let begun = Instant::now();
        rayon::broadcast(|_| run());
        begun.elapsed()
    };
    let best = (0..ROUNDS).map(round).min().unwrap_or(Duration::MAX);
    best.as_secs_f64() * threads as f64
}

/// Both ways of asking, beside the peak.
///
/// # Errors
/// When the SIMD level is not there.
pub fn measure(simd: SimdLevel, machine: &Machine) -> Result<Vec<StageCost>, Error> {
    let setting = Setting::new(simd)?;
    let level = simd.token()?;
    let units = (SAMPLES * machine.threads) as u64;
    let flops = 2.0 * setting.nerf.multiply_adds() as f64;
    let Setting { nerf, layout, parameters, rounded, .. } = &setting;
    let half = AnyField::Nerf(nerf.view(layout, 1.0, |range| rounded.tensor(range))?);
    let full = nerf.view(layout, 1.0, |range| range.of(parameters))?;
    let forward = fastest(machine.threads, || {
        dispatch!(level, simd => setting.forward(simd, &half));
    });
    let both = fastest(machine.threads, || {
        dispatch!(level, simd => setting.both_ways(simd, &full));
    });
    let back = 2.0 * flops - 2.0 * unread(&setting.nerf);
    let cost = |name, seconds, flops| {
        let demand = Demand::fma(flops);
        let measured = Measured { name, unit: "sample", units, seconds, demand };
        stages(&[measured], seconds, units, machine, Crowd::All).swap_remove(0)
    };
    Ok(vec![cost("8x256 forward", forward, flops), cost("8x256 both ways", both, flops + back)])
}

/// Multiply-adds that the gradients of encoded points and directions would take, for
/// which nobody asks.
fn unread(nerf: &NerfConfig) -> f64 {
    let positions = (2 * nerf.positions.n_output() * nerf.width) as f64;
    positions + (nerf.n_direction() * nerf.color_width) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_by_hand() {
        let nerf = NerfConfig { coarse: false, ..NerfConfig::vanilla() };
        let trunk = 63 * 256 + 6 * 256 * 256 + (63 + 256) * 256;
        let heads = 256 + 256 * 256 + 283 * 128 + 128 * 3;
        assert_eq!(nerf.multiply_adds(), trunk + heads);
        assert_eq!(unread(&nerf), f64::from(2 * 63 * 256 + 27 * 128));
    }
}
