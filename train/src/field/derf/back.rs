//! A group's way back: each head's own samples through its network.

use std::sync::MutexGuard;

use fearless_simd::{Level, Simd, dispatch};
use pocketnerf_core::field::{DerfField, NerfField};
use pocketnerf_core::network::blocks::BLOCK;

use super::TrainableDerf;
use crate::field::nerf::{NerfGradients, NerfTape, NerfWork, d_raw};
use crate::field::{Back, Context, SampleGradients};
use crate::pool::Lease;
use crate::stopwatch::{Laps, Stage, Stopwatch};

/// Samples that go back together.
const TOGETHER: usize = 512;

/// Memory of one thread.
#[derive(Debug)]
pub(super) struct Worker {
    tape: NerfTape,
    work: NerfWork,
    /// The head of each sample.
    nearest: Vec<f32>,
    /// Numbers of a head's samples.
    own: Vec<usize>,
    /// Their points and directions.
    gathered: [Vec<f32>; 6],
}

impl Worker {
    fn new(networks: &NerfGradients) -> Self {
        Self {
            tape: NerfTape::new(networks.config(), TOGETHER),
            work: networks.work(TOGETHER),
            nearest: Vec::new(),
            own: Vec::new(),
            gathered: Default::default(),
        }
    }
}

/// The way back.
#[derive(Debug)]
pub(super) struct DerfBack<'a> {
    networks: &'a [NerfGradients],
    field: DerfField<'a>,
    heads: Vec<NerfField<'a>>,
    level: Level,
    stopwatch: Option<&'a Stopwatch>,
    gradient: MutexGuard<'a, Vec<f32>>,
    worker: Lease<'a, Worker>,
}

impl<'a> DerfBack<'a> {
    pub(super) fn new(
        owner: &'a TrainableDerf,
        gradient: MutexGuard<'a, Vec<f32>>,
        context: Context<'a>,
    ) -> Self {
        let Context { level, stopwatch, parameters } = context;
        let field = owner.field(parameters).expect("checked when training began");
        let heads = (0..field.n_heads()).map(|head| field.head(head));
        let heads = heads.collect::<Result<_, _>>().expect("checked when training began");
        let networks = &owner.networks;
        let worker = owner.workers.lease(|| Worker::new(&networks[0]));
        Self { networks, field, heads, level, stopwatch, gradient, worker }
    }

    /// Forwards again, everything kept, then backwards, one head after the other.
    #[inline(always)]
    fn samples_back<S: Simd>(&mut self, simd: S, samples: &SampleGradients<'_>) {
        let Self { networks, field, heads, gradient, worker, .. } = self;
        let Worker { tape, work, nearest, own, gathered } = &mut **worker;
        nearest.resize(samples.len, 0.0);
        field.nearest(samples.points.map(|row| &row[..samples.len]), nearest);
        let gradients = gradient.chunks_exact_mut(field.shape.n_parameters());
        for (number, ((networks, head), gradient)) in
            networks.iter().zip(heads).zip(gradients).enumerate()
        {
            own.clear();
            own.extend((0..samples.len).filter(|s| nearest[*s] == number as f32));
            for own in own.chunks(TOGETHER) {
                let rows = samples.points.iter().chain(&samples.directions);
                for (to, row) in gathered.iter_mut().zip(rows) {
                    to.clear();
                    to.extend(own.iter().map(|s| row.get(*s).copied().unwrap_or(0.0)));
                    to.resize(own.len().next_multiple_of(BLOCK), 0.0);
                }
                let [x, y, z, dx, dy, dz] = &*gathered;
                tape.forward(simd, head, [x, y, z], [dx, dy, dz]);
                for (i, s) in own.iter().enumerate() {
                    let row = &samples.gradients[s * samples.row_len..][..4];
                    let sigma = samples.sigma[*s];
                    // Without a density, nothing goes back.
                    let d = if sigma > 0.0 { d_raw(head, sigma, row[0] / sigma) } else { 0.0 };
                    tape.set_gradient(i, d, [row[1], row[2], row[3]]);
                }
                tape.clear_from(own.len());
                networks.backward(simd, false, tape, work, gradient);
            }
        }
    }
}

impl Back for DerfBack<'_> {
    fn samples(&mut self, samples: &SampleGradients<'_>) {
        let mut laps = Laps::begin(self.stopwatch);
        dispatch!(self.level, simd => self.samples_back(simd, samples));
        laps.end(Stage::Backward, samples.len);
    }
}
