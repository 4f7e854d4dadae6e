//! A group's way back: batches of samples through the network, forwards with everything
//! kept, then backwards.

use std::sync::MutexGuard;

use fearless_simd::{Level, Simd, SimdBase, dispatch};
use pocketnerf_core::field::NerfField;
use pocketnerf_core::network::blocks::BLOCK;

use super::TrainableNerf;
use super::backward::{NerfGradients, NerfWork, slope};
use super::tape::NerfTape;
use crate::field::{Back, Context, HIERARCHICAL_RAYS, Network, SampleGradients, Tape};
use crate::pool::Lease;
use crate::stopwatch::{Laps, Stage, Stopwatch};

/// Samples that go back together: what a layer gave for them, half a megabyte, stays in a
/// core's second-level cache until it has been read twice.
const TOGETHER: usize = 512;

/// Memory of one thread.
#[derive(Debug)]
pub(super) struct Worker {
    /// What the fine network gave, then the coarse one where it is trained.
    tapes: [NerfTape; 2],
    work: NerfWork,
}

impl Worker {
    fn new(gradients: &NerfGradients) -> Self {
        let config = gradients.config();
        let most = config.hierarchical.map_or([TOGETHER, 0], |training| {
            let coarse = training.sampling.n_coarse as usize;
            let samples = [training.sampling.n_all(), coarse];
            samples.map(|n| HIERARCHICAL_RAYS * n.next_multiple_of(BLOCK))
        });
        Self {
            tapes: most.map(|samples| NerfTape::new(config, samples)),
            work: gradients.work(most[0]),
        }
    }
}

/// The way back.
#[derive(Debug)]
pub(super) struct NerfBack<'a> {
    networks: &'a NerfGradients,
    /// Whose fine network is the fine one, and whose is the coarse one, where there is one.
    fields: [NerfField<'a>; 2],
    level: Level,
    stopwatch: Option<&'a Stopwatch>,
    gradient: MutexGuard<'a, Vec<f32>>,
    worker: Lease<'a, Worker>,
}

impl<'a> NerfBack<'a> {
    pub(super) fn new(
        owner: &'a TrainableNerf,
        gradient: MutexGuard<'a, Vec<f32>>,
        context: Context<'a>,
    ) -> Self {
        let Context { level, stopwatch, parameters } = context;
        let field = owner.field(parameters).expect("checked when training began");
        let networks = &owner.networks;
        let worker = owner.workers.lease(|| Worker::new(networks));
        let fields = [field, field.coarse_field()];
        Self { networks, fields, level, stopwatch, gradient, worker }
    }

    /// Forwards again, everything kept, then backwards.
    #[inline(always)]
    fn samples_back<S: Simd>(&mut self, simd: S, samples: &SampleGradients<'_>) {
        let Self { networks, fields: [field, _], gradient, worker, .. } = self;
        let Worker { tapes: [tape, _], work } = &mut **worker;
        let padded = samples.points[0].len();
        for first in (0..samples.len).step_by(TOGETHER) {
            let end = (first + TOGETHER).min(padded);
            let len = TOGETHER.min(samples.len - first);
            let points = samples.points.map(|row| &row[first..end]);
            let directions = samples.directions.map(|row| &row[first..end]);
            tape.forward(simd, field, points, directions);
            let rows = samples.gradients[first * samples.row_len..].chunks_exact(samples.row_len);
            for (s, (row, sigma)) in rows.zip(&samples.sigma[first..]).take(len).enumerate() {
                // Without a density, nothing goes back.
                let d_raw = if *sigma > 0.0 { d_raw(field, *sigma, row[0] / sigma) } else { 0.0 };
                tape.set_gradient(s, d_raw, [row[1], row[2], row[3]]);
            }
            tape.clear_from(len);
            networks.backward(simd, false, tape, work, gradient);
        }
    }
}

/// From the gradient of a density to that of what is before its activation.
pub(in crate::field) fn d_raw(field: &NerfField<'_>, sigma: f32, d_sigma: f32) -> f32 {
    let slope = slope(field.activation, sigma / field.density_scale);
    d_sigma * field.density_scale * slope
}

impl Back for NerfBack<'_> {
    fn samples(&mut self, samples: &SampleGradients<'_>) {
        let mut laps = Laps::begin(self.stopwatch);
        dispatch!(self.level, simd => self.samples_back(simd, samples));
        laps.end(Stage::Backward, samples.len);
    }

    fn tape(&mut self) -> Option<&mut dyn Tape> {
        Some(self)
    }
}

impl NerfBack<'_> {
    fn of(&mut self, network: Network) -> (&NerfField<'_>, &mut NerfTape) {
        let Worker { tapes: [fine, coarse], .. } = &mut *self.worker;
        match network {
            Network::Fine => (&self.fields[0], fine),
            Network::Coarse => (&self.fields[1], coarse),
        }
    }
}

impl Tape for NerfBack<'_> {
    fn forward(&mut self, network: Network, points: [&[f32]; 3], directions: [&[f32]; 3]) {
        let level = self.level;
        let (field, tape) = self.of(network);
        dispatch!(level, simd => tape.forward(simd, field, points, directions));
    }

    fn raw(&mut self, network: Network) -> &mut [f32] {
        let (_, tape) = self.of(network);
        tape.raw()
    }

    fn densities(&mut self, network: Network, sigma: &mut Vec<f32>) {
        let level = self.level;
        let (field, tape) = self.of(network);
        sigma.clear();
        sigma.extend_from_slice(tape.raw());
        dispatch!(level, simd => activate(simd, field, sigma));
    }

    fn color(&self, network: Network, sample: usize) -> [f32; 3] {
        self.worker.tapes[usize::from(network == Network::Coarse)].color(sample)
    }

    fn set_gradient(
        &mut self,
        network: Network,
        sample: usize,
        sigma: f32,
        d_sigma: f32,
        d_color: [f32; 3],
    ) {
        let (field, tape) = self.of(network);
        tape.set_gradient(sample, d_raw(field, sigma, d_sigma), d_color);
    }

    fn back(&mut self, network: Network, len: usize) {
        let Self { networks, level, gradient, worker, .. } = self;
        let Worker { tapes: [fine, coarse], work } = &mut **worker;
        let tape = if network == Network::Coarse { coarse } else { fine };
        // Without a coarse network the fine one decides where samples lie, too.
        let coarse = network == Network::Coarse && networks.config().coarse;
        tape.clear_from(len);
        dispatch!(*level, simd => networks.backward(simd, coarse, tape, work, gradient));
    }
}

/// From what is before the activation to densities.
#[inline(always)]
fn activate<S: Simd>(simd: S, field: &NerfField<'_>, values: &mut [f32]) {
    simd.vectorize(
        #[inline(always)]
        || {
            for values in values.chunks_exact_mut(S::f32s::LEN) {
                let raw = S::f32s::from_slice(simd, values);
                field.sigma(simd, raw).store_slice(values);
            }
        },
    );
}
