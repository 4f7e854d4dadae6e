//! Training by hierarchical sampling (Mildenhall et al. 2020, section 5): stratified
//! samples for the coarse network, more where its weights are for the fine one, the
//! error of both, and back.

use std::ops::Range;

use fearless_simd::Simd;
use pocketnerf_core::lanes::LANES;
use pocketnerf_core::march::Hierarchical;
use pocketnerf_core::march::composite::{Lengths, opacities};
use pocketnerf_core::march::hierarchical::{
    ENDLESS, Extent, Points, evenly, inverse_cdf, jitter, lengths, merge,
};
use pocketnerf_core::network::blocks::BLOCK;
use pocketnerf_core::{Ray, Space};

use super::group::{Group, Job};
use crate::field::{HIERARCHICAL_RAYS, HierarchicalTraining, Network, Tape};
use crate::random::{Random, normal};
use crate::trainer::loss::{Rendered, loss};

/// A ray, and its part in the space.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Number of the ray.
    ray: usize,
    /// In scene space.
    public: Ray,
    /// Where it has its samples.
    extent: Extent,
}

/// Samples of a few rays, one ray after another.
#[derive(Debug, Default)]
struct Samples {
    t: Vec<f32>,
    /// Unit coordinates and directions, filled up to whole blocks.
    axes: [Vec<f32>; 6],
    /// 1 / scene unit.
    sigma: Vec<f32>,
    alpha: Vec<f32>,
    /// Light that comes to each.
    before: Vec<f32>,
    weights: Vec<f32>,
}

/// What is evaluated.
#[derive(Clone, Copy)]
struct Pass<'q> {
    network: Network,
    lines: &'q [Line],
    space: &'q Space,
    /// Standard deviation of what is added to densities.
    noise: f32,
}

impl Samples {
    /// Evaluates a network at all samples.
    #[inline(always)]
    fn evaluate<S: Simd>(
        &mut self,
        simd: S,
        pass: Pass<'_>,
        tape: &mut dyn Tape,
        random: &mut Random,
    ) {
        let Pass { network, lines, space, noise } = pass;
        let n = self.t.len() / lines.len();
        let map = space.unit_map();
        self.axes.iter_mut().for_each(Vec::clear);
        for (line, t) in lines.iter().zip(self.t.chunks_exact(n)) {
            let mut points = Points::new(space, line.public);
            for t in t {
                let u = map.apply(points.at(*t));
                let values = u.into_iter().chain(line.public.direction);
                self.axes.iter_mut().zip(values).for_each(|(axis, value)| axis.push(value));
            }
        }
        let padded = self.t.len().next_multiple_of(BLOCK);
        self.axes.iter_mut().for_each(|axis| axis.resize(padded, 0.0));
        let [x, y, z, dx, dy, dz] = self.axes.each_ref().map(|axis| &axis[..]);
        tape.forward(network, [x, y, z], [dx, dy, dz]);
        if noise > 0.0 {
            tape.raw(network).iter_mut().for_each(|raw| *raw += noise * normal(random));
        }
        tape.densities(network, &mut self.sigma);
        for list in [&mut self.alpha, &mut self.before, &mut self.weights] {
            list.clear();
        }
        for (r, line) in lines.iter().enumerate() {
            let own = r * n..(r + 1) * n;
            let padded = n.next_multiple_of(LANES);
            let mut alpha = self.sigma[own.clone()].to_vec();
            alpha.resize(padded, 0.0);
            let mut own_lengths = vec![0.0; padded];
            lengths(&self.t[own], line.extent.end, &mut own_lengths);
            opacities(simd, &mut alpha, Lengths::Each(&own_lengths, 1.0));
            let mut before = 1.0;
            for alpha in &alpha[..n] {
                self.alpha.push(*alpha);
                self.before.push(before);
                self.weights.push(before * alpha);
                before *= 1.0 - alpha;
            }
        }
    }
}

impl Group {
    /// Forwards and backwards, a few rays at a time.
    #[inline(always)]
    pub(super) fn run_hierarchical<S: Simd>(
        &mut self,
        simd: S,
        job: &Job<'_>,
        training: &HierarchicalTraining,
        tape: &mut dyn Tape,
    ) {
        let mut random = self.random.take().expect("set with the rays");
        let sampling = &training.sampling;
        let [n_coarse, n_all] = [sampling.n_coarse as usize, sampling.n_all()];
        let (mut first, mut all) = (Samples::default(), Samples::default());
        let mut found = vec![0.0; n_all - n_coarse];
        let mut u = found.clone();
        let (mut next, mut lines) = (0, Vec::with_capacity(HIERARCHICAL_RAYS));
        loop {
            lines.clear();
            while next < self.rays.len() && lines.len() < HIERARCHICAL_RAYS {
                match self.line(next, job, sampling) {
                    Some(line) => lines.push(line),
                    None => self.loss_of_nothing(job, next),
                }
                next += 1;
            }
            if lines.is_empty() {
                return;
            }
            first.t.clear();
            for line in &lines {
                let start = first.t.len();
                first.t.resize(start + n_coarse, 0.0);
                evenly(line.extent.near, line.extent.far, &mut first.t[start..]);
                jitter(&mut first.t[start..], || random.next_f32());
            }
            let (space, lines) = (&job.space, &lines[..]);
            let pass = Pass { network: Network::Coarse, lines, space, noise: training.noise };
            first.evaluate(simd, pass, tape, &mut random);
            all.t.clear();
            for (t, weights) in
                first.t.chunks_exact(n_coarse).zip(first.weights.chunks_exact(n_coarse))
            {
                // One in each of as many equal parts: ascending.
                let share = 1.0 / found.len() as f32;
                u.iter_mut().zip(0u16..).for_each(|(u, i)| {
                    *u = (f32::from(i) + random.next_f32()) * share;
                });
                inverse_cdf(t, weights, |i| u[i], &mut found);
                let start = all.t.len();
                all.t.resize(start + n_all, 0.0);
                merge(t, &found, &mut all.t[start..]);
            }
            let pass = Pass { network: Network::Fine, ..pass };
            all.evaluate(simd, pass, tape, &mut random);
            self.stats.samples += lines.len() * (n_coarse + n_all);
            for (r, line) in lines.iter().enumerate() {
                let own = r * n_all..(r + 1) * n_all;
                self.compare_along(job, &all, own, (Network::Fine, &mut *tape), line);
                let own = r * n_coarse..(r + 1) * n_coarse;
                self.compare_along(job, &first, own, (Network::Coarse, &mut *tape), line);
            }
            tape.back(Network::Fine, all.t.len());
            tape.back(Network::Coarse, first.t.len());
            self.stats.kept = self.stats.samples;
        }
    }

    /// A ray's way through the space, where it has one.
    fn line(&self, ray: usize, job: &Job<'_>, sampling: &Hierarchical) -> Option<Line> {
        let public = self.rays[ray].ray;
        let extent = sampling.extent(&job.space, &public, job.reach, 1.0)?;
        let line = Line { ray, public, extent };
        (extent.near < extent.far).then_some(line)
    }

    /// The error of a ray's colour, which counts as the step's where the network is the
    /// fine one, and its gradient, which goes to the tape. `own` are the ray's samples.
    fn compare_along(
        &mut self,
        job: &Job<'_>,
        samples: &Samples,
        own: Range<usize>,
        (network, tape): (Network, &mut dyn Tape),
        line: &Line,
    ) {
        let (mut color, mut opacity, mut depth) = ([0.0; 3], 0.0, 0.0);
        for s in own.clone() {
            opacity += samples.weights[s];
            depth += samples.weights[s] * samples.t[s];
            for (sum, c) in color.iter_mut().zip(tape.color(network, s)) {
                *sum += samples.weights[s] * c;
            }
        }
        let background = self.rays[line.ray].background;
        for (sum, b) in color.iter_mut().zip(background) {
            *sum += (1.0 - opacity) * b;
        }
        let rendered = Rendered { color, opacity, depth };
        let loss = match network {
            Network::Fine => self.loss(job, line.ray, &rendered),
            Network::Coarse => loss(job.terms, &self.rays[line.ray], &rendered),
        };
        let needs_depth = job.needs_depth();
        // Where the last sample's part is endless, it is opaque or nothing.
        let mut next =
            if line.extent.end < ENDLESS { line.extent.end } else { samples.t[own.end - 1] };
        let mut suffix = 0.0;
        for s in own.rev() {
            let rgb = tape.color(network, s);
            let unlike = (0..3).map(|c| loss.d_color[c] * (rgb[c] - background[c]));
            let mut d_weight = loss.d_opacity + unlike.sum::<f32>();
            if needs_depth {
                d_weight += loss.d_depth * samples.t[s];
            }
            let passed = samples.before[s] * (1.0 - samples.alpha[s]);
            let d_sigma = (next - samples.t[s]) * (passed * d_weight - suffix);
            suffix += samples.weights[s] * d_weight;
            next = samples.t[s];
            let d_color = loss.d_color.map(|d| samples.weights[s] * d);
            tape.set_gradient(network, s, samples.sigma[s], d_sigma, d_color);
        }
    }
}
