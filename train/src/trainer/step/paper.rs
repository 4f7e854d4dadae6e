//! The paper's way through a scene (Mildenhall et al. 2020, section 5): stratified
//! samples for the coarse network, more where its weights are for the fine one, the
//! error of both, and back.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase};
use pocketnerf_core::Space;
use pocketnerf_core::field::NerfField;
use pocketnerf_core::lanes::LANES;
use pocketnerf_core::march::composite::{Lengths, opacities};
use pocketnerf_core::march::hierarchical::{
    ENDLESS, Extent, evenly, inverse_cdf, jitter, lengths, merge,
};
use pocketnerf_core::network::blocks::BLOCK;

use super::group::{Group, Job, Worker};
use super::worker::NerfWorker;
use crate::field::{Tape, slope};
use crate::random::{Random, normal};
use crate::trainer::config::Paper;
use crate::trainer::pixels::rays::{Pixel, RaySource};

/// Rays that go through the networks together: few enough that what all layers gave for
/// their 768 samples, 8 MB, is still in the third-level cache on the way back.
pub(crate) const RAYS: usize = 4;

/// Pixels drawn at most until one counts.
const DRAWS: u32 = 64;

/// A ray in its space.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Number of the ray.
    ray: usize,
    origin: [f32; 3],
    direction: [f32; 3],
    /// Where it looks in scene space.
    view: [f32; 3],
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

/// What is asked.
struct Question<'q> {
    lines: &'q [Line],
    field: &'q NerfField<'q>,
    space: &'q Space,
    paper: &'q Paper,
}

impl Samples {
    /// Asks the fine network of the field at all samples.
    #[inline(always)]
    fn ask<S: Simd>(
        &mut self,
        simd: S,
        question: &Question<'_>,
        tape: &mut Tape,
        random: &mut Random,
    ) {
        let Question { lines, field, space, paper } = *question;
        let n = self.t.len() / lines.len();
        let map = space.unit_map();
        self.axes.iter_mut().for_each(Vec::clear);
        for (line, t) in lines.iter().zip(self.t.chunks_exact(n)) {
            for t in t {
                let u = map.apply([0, 1, 2].map(|a| line.origin[a] + t * line.direction[a]));
                let values = u.into_iter().chain(line.view);
                self.axes.iter_mut().zip(values).for_each(|(axis, value)| axis.push(value));
            }
        }
        let padded = self.t.len().next_multiple_of(BLOCK);
        self.axes.iter_mut().for_each(|axis| axis.resize(padded, 0.0));
        let [x, y, z, dx, dy, dz] = self.axes.each_ref().map(|axis| &axis[..]);
        tape.forward(simd, field, [x, y, z], [dx, dy, dz]);
        if paper.noise > 0.0 {
            tape.raw().iter_mut().for_each(|raw| *raw += paper.noise * normal(random));
        }
        self.sigma.clear();
        self.sigma.extend_from_slice(tape.raw());
        simd.vectorize(
            #[inline(always)]
            || {
                for values in self.sigma.chunks_exact_mut(S::f32s::LEN) {
                    let raw = S::f32s::from_slice(simd, values);
                    field.sigma(simd, raw).store_slice(values);
                }
            },
        );
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
    /// Draws `n` rays from all pixels of all views; from the middle halves of the images
    /// where `cropped`.
    pub(crate) fn draw_anywhere(
        &mut self,
        source: &RaySource,
        n: usize,
        cropped: bool,
        mut random: Random,
    ) {
        self.rays.clear();
        self.rays.extend((0..n).map(|_| {
            let mut draw = || {
                let view = random.below(source.cameras().len());
                let camera = &source.cameras()[view];
                let mut along = |pixels: u32| {
                    let most = if cropped { (pixels / 2).max(1) } else { pixels };
                    (pixels - most) / 2 + random.below(most as usize) as u32
                };
                Pixel { view: view as u32, x: along(camera.width), y: along(camera.height) }
            };
            let mut pixel = draw();
            for _ in 0..DRAWS {
                let width = source.cameras()[pixel.view as usize].width;
                if source.counts(pixel.view as usize, (pixel.y * width + pixel.x) as usize) {
                    break;
                }
                pixel = draw();
            }
            source.ray(pixel, source.rgba(pixel), (0, 1.0), &mut random)
        }));
        self.errors.clear();
        self.errors.resize(n, 0.0);
        self.random = Some(random);
    }

    /// Everything, a few rays at a time.
    #[inline(always)]
    pub(crate) fn run_paper<S: Simd>(
        &mut self,
        simd: S,
        field: &NerfField<'_>,
        job: &Job<'_>,
        paper: &Paper,
        worker: &mut Worker,
    ) {
        let Worker { nerf: Some(nerf), .. } = worker else { return };
        let Some(gradients) = job.backward.nerf() else { return };
        let NerfWorker { tapes: [fine_tape, coarse_tape], work } = nerf;
        let mut random = self.random.take().expect("set with the rays");
        let [n_coarse, n_all] = [paper.sampling.n_coarse as usize, paper.sampling.n_all()];
        let coarse_field = field.coarse_field();
        let (mut first, mut all) = (Samples::default(), Samples::default());
        let mut found = vec![0.0; n_all - n_coarse];
        let mut u = found.clone();
        let has_coarse = gradients.config().coarse;
        let (mut next, mut lines) = (0, Vec::with_capacity(RAYS));
        loop {
            lines.clear();
            while next < self.rays.len() && lines.len() < RAYS {
                match self.line(next, job, paper) {
                    Some(line) => lines.push(line),
                    None => {
                        let background = self.rays[next].background;
                        let _ = self.error(next, background, 0.0);
                    }
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
            let question = Question { lines, field: &coarse_field, space, paper };
            first.ask(simd, &question, coarse_tape, &mut random);
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
            let question = Question { field, ..question };
            all.ask(simd, &question, fine_tape, &mut random);
            self.stats.samples += lines.len() * (n_coarse + n_all);
            for (r, line) in lines.iter().enumerate() {
                self.compare_along(&all, r * n_all..(r + 1) * n_all, fine_tape, line, field, true);
                let own = r * n_coarse..(r + 1) * n_coarse;
                self.compare_along(&first, own, coarse_tape, line, field, false);
            }
            fine_tape.clear_from(all.t.len());
            gradients.backward(simd, false, fine_tape, work, &mut self.network_gradient);
            coarse_tape.clear_from(first.t.len());
            gradients.backward(simd, has_coarse, coarse_tape, work, &mut self.network_gradient);
            self.stats.kept = self.stats.samples;
        }
    }

    /// A ray's way through the space, where it has one.
    fn line(&self, ray: usize, job: &Job<'_>, paper: &Paper) -> Option<Line> {
        let public = self.rays[ray].ray;
        let local = job.space.local(&public)?;
        let extent = paper.sampling.extent(&job.space, &local, job.reach, 1.0)?;
        let (origin, direction, view) = (local.origin, local.direction, public.direction);
        let line = Line { ray, origin, direction, view, extent };
        (extent.near < extent.far).then_some(line)
    }

    /// The error of a ray's colour, which counts as the step's where it is `last`, and
    /// its gradient, which goes to the tape. `own` are the ray's samples.
    fn compare_along(
        &mut self,
        samples: &Samples,
        own: Range<usize>,
        tape: &mut Tape,
        line: &Line,
        field: &NerfField<'_>,
        last: bool,
    ) {
        let (mut color, mut opacity) = ([0.0; 3], 0.0);
        for s in own.clone() {
            opacity += samples.weights[s];
            for (sum, c) in color.iter_mut().zip(tape.color(s)) {
                *sum += samples.weights[s] * c;
            }
        }
        let background = self.rays[line.ray].background;
        for (sum, b) in color.iter_mut().zip(background) {
            *sum += (1.0 - opacity) * b;
        }
        let error = match last {
            true => self.error(line.ray, color, opacity),
            false => self.rays[line.ray].error(color, opacity),
        };
        // Where the last sample's part is endless, it is opaque or nothing.
        let mut next =
            if line.extent.end < ENDLESS { line.extent.end } else { samples.t[own.end - 1] };
        let mut suffix = 0.0;
        for s in own.rev() {
            let rgb = tape.color(s);
            let unlike = (0..3).map(|c| error.d_color[c] * (rgb[c] - background[c]));
            let d_weight = error.d_opacity + unlike.sum::<f32>();
            let passed = samples.before[s] * (1.0 - samples.alpha[s]);
            let d_sigma = (next - samples.t[s]) * (passed * d_weight - suffix);
            suffix += samples.weights[s] * d_weight;
            next = samples.t[s];
            let slope = slope(field.activation, samples.sigma[s] / field.density_scale);
            let d_raw = d_sigma * field.density_scale * slope;
            tape.set_gradient(s, d_raw, error.d_color.map(|d| samples.weights[s] * d));
        }
    }
}
