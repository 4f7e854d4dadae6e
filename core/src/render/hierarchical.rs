//! Pictures by hierarchical sampling (Mildenhall et al. 2020, section 5.2): samples
//! spread along all of a ray, more of them where those have weight, all of them added up.
//!
//! Some rays travel together, so that batches are full: one round through the coarse
//! field, one through the fine one.

use fearless_simd::Simd;

use crate::lanes::LANES;
use crate::march::composite::{Lengths, opacities};
use crate::march::hierarchical::{ENDLESS, Extent, Points, evenly, inverse_cdf, merge, weights};
use crate::march::{Hierarchical, Output, RayPacket, RaySlot, RayState, Reach, Stage, evaluate};
use crate::render::driver::Job;
use crate::render::ray_group::RayGroup;
use crate::render::source::Source;
use crate::render::target::Target;
use crate::scratch::{Scratch, sums_len};
use crate::space::UnitMap;
use crate::{AnyField, Model, Ray, Sampling, Space};

/// Bits of a sample's number within its ray: no ray has more than 2048.
const NUMBER_BITS: u32 = 11;

/// Renders every pixel.
pub(super) fn each_pixel<S: Simd>(
    simd: S,
    hierarchical: &Hierarchical,
    group: &mut RayGroup<'_, '_, '_, '_>,
    job: &Job<'_, impl Source + ?Sized>,
    target: &mut Target<'_>,
) {
    // No ray ends early.
    group.scratch.slots.limits.min_transmittance = 0.0;
    let field = &group.model.field;
    let coarse = field.coarse();
    let [coarse, fine] = [coarse.as_ref().unwrap_or(field), field];
    let rays = Rays::new(hierarchical, group, job);
    let size = target.size;
    let mut pixels = job.span.passes(size).flat_map(|pass| pass.pixels());
    loop {
        let (mut numbers, mut n) = ([0; LANES], 0);
        let room = LANES.min(rays.most - group.count());
        for [x, y] in pixels.by_ref() {
            let number = y * size[0] + x;
            if rays.clipped && target.foreground.depth([x, y]) == f32::INFINITY {
                target.clear(number);
                continue;
            }
            numbers[n] = number;
            n += 1;
            if n == room {
                break;
            }
        }
        group.stats.rays += n as u64;
        let mut packet = RayPacket::EMPTY;
        job.source.fill(simd, &numbers[..n], &mut packet);
        for (lane, number) in numbers[..n].iter().enumerate() {
            match rays.extent(&packet, lane) {
                Some(extent) => {
                    rays.spread(group, extent);
                    group.scratch.slots.push(&packet, lane, *number);
                }
                None => target.clear(*number),
            }
        }
        group.ended(Stage::Camera, n);
        if group.count() == rays.most || n < room {
            let count = group.count();
            group.scratch.sums[..count * sums_len(fine.channels())].fill(0.0);
            if hierarchical.n_fine > 0 {
                rays.round(simd, coarse, group, Round::Coarse);
                rays.draw(group);
            }
            group.stats.hits += rays.round(simd, fine, group, Round::Fine);
            group.finish(simd, job.source, target);
            group.ended(Stage::Shade, count);
        }
        if n < room || group.is_spent() {
            return;
        }
    }
}

/// What samples are for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Round {
    /// Opacities, from which distances are drawn.
    Coarse,
    /// The picture.
    Fine,
}

/// Where the samples of rays lie.
struct Rays {
    hierarchical: Hierarchical,
    clipped: bool,
    /// Direction along which `near` and `far` are measured, if not along rays.
    axis: Option<[f32; 3]>,
    space: Space,
    map: UnitMap,
    sampling: Sampling,
    /// Rays that travel together at most.
    most: usize,
    /// Values kept of a ray's samples.
    row: usize,
}

impl Rays {
    fn new(
        hierarchical: &Hierarchical,
        group: &RayGroup<'_, '_, '_, '_>,
        job: &Job<'_, impl Source + ?Sized>,
    ) -> Self {
        let (model, limits) = (group.model, job.options.limits);
        Self {
            hierarchical: *hierarchical,
            clipped: hierarchical.reach == Reach::Clipped,
            axis: job.source.axis().filter(|_| hierarchical.reach == Reach::Depth),
            space: model.space,
            map: model.space.unit_map(),
            sampling: model.sampling,
            most: limits.hierarchical_rays(group.tuning),
            row: limits.ray_samples,
        }
    }

    /// Where the ray in a lane has its samples.
    fn extent(&self, packet: &RayPacket, lane: usize) -> Option<Extent> {
        let Sampling { near, far, .. } = self.sampling;
        let [origin, direction] =
            [&packet.origin, &packet.direction].map(|rows| [0, 1, 2].map(|a| rows[a][lane]));
        let stretch = self.axis.map_or(1.0, |axis| stretch(axis, direction));
        self.hierarchical.extent(&self.space, &Ray { origin, direction }, [near, far], stretch)
    }

    /// Spreads the samples of the next ray evenly.
    fn spread(&self, group: &mut RayGroup<'_, '_, '_, '_>, extent: Extent) {
        let n = self.hierarchical.n_coarse as usize;
        // Without a second round, these are the picture's.
        let which = if self.hierarchical.n_fine > 0 { 0 } else { 1 };
        let count = group.count();
        evenly(extent.near, extent.far, &mut self.rows(group, count)[which][..n]);
    }

    /// Of a ray: distances of the first round, later free; its opacities, then the
    /// distances of the second.
    fn rows<'g>(&self, group: &'g mut RayGroup<'_, '_, '_, '_>, ray: usize) -> [&'g mut [f32]; 2] {
        rows(group.scratch.hierarchical.rays, self.row, ray)
    }

    /// Draws distances from the opacities of the first round.
    fn draw(&self, group: &mut RayGroup<'_, '_, '_, '_>) {
        let Hierarchical { n_coarse, n_fine, .. } = self.hierarchical;
        let (n, last) = (n_coarse as usize, n_fine.max(2) - 1);
        let mut found = core::mem::take(&mut group.scratch.hierarchical.found);
        for ray in 0..group.count() {
            let [first, all] = self.rows(group, ray);
            weights(&mut all[..n]);
            let found = &mut found[..n_fine as usize];
            inverse_cdf(&first[..n], &all[..n], |i| i as f32 / last as f32, found);
            merge(&first[..n], found, &mut all[..self.hierarchical.n_all()]);
        }
        core::mem::swap(&mut group.scratch.hierarchical.found, &mut found);
    }

    /// Evaluates the field at all samples of all rays; returns how many rays have any.
    fn round<S: Simd>(
        &self,
        simd: S,
        field: &AnyField<'_>,
        group: &mut RayGroup<'_, '_, '_, '_>,
        round: Round,
    ) -> u64 {
        let n = match round {
            Round::Coarse => self.hierarchical.n_coarse as usize,
            Round::Fine => self.hierarchical.n_all(),
        };
        // Where samples end where the ray leaves the space, the last stands for nothing.
        let last = if self.clipped { 0.0 } else { ENDLESS };
        let mut hits = 0;
        group.scratch.samples.len = 0;
        for ray in 0..group.count() {
            let RayState { origin, direction, .. } =
                RaySlot::load(&group.scratch.slots.rays[ray]).state;
            let mut points = Points::new(&self.space, Ray { origin, direction });
            let mut is_hit = false;
            for i in 0..n {
                let Scratch { samples, slots, hierarchical, .. } = &mut group.scratch;
                let [first, second] = rows(hierarchical.rays, self.row, ray);
                let distances = if round == Round::Coarse { &first[..n] } else { &second[..n] };
                let t = distances[i];
                let length = distances.get(i + 1).map_or(last, |next| next - t);
                let Some(u) = self.place(group.model, points.at(t)) else {
                    if round == Round::Coarse {
                        second[i] = 0.0;
                    }
                    continue;
                };
                let s = samples.len;
                samples.points.iter_mut().zip(u).for_each(|(row, u)| row[s] = u);
                samples.directions.iter_mut().zip(direction).for_each(|(row, d)| row[s] = d);
                samples.t[s] = t;
                hierarchical.lengths[s] = length;
                slots.runs[s] = (ray << NUMBER_BITS | i) as u32;
                is_hit = true;
                samples.len += 1;
                if samples.len == samples.capacity {
                    self.accumulate(simd, field, group, round);
                }
            }
            hits += u64::from(is_hit);
        }
        if group.scratch.samples.len > 0 {
            self.accumulate(simd, field, group, round);
        }
        hits
    }

    /// The unit coordinates of a sample; `None` where the field is not evaluated.
    #[inline(always)]
    fn place(&self, model: &Model<'_>, p: [f32; 3]) -> Option<[f32; 3]> {
        if self.clipped { model.place(&self.map, p) } else { Some(self.map.apply(p)) }
    }

    /// Evaluates the batch and adds it to its rays.
    fn accumulate<S: Simd>(
        &self,
        simd: S,
        field: &AnyField<'_>,
        group: &mut RayGroup<'_, '_, '_, '_>,
        round: Round,
    ) {
        let RayGroup { scratch, stats, observer, .. } = group;
        let Scratch { work, samples, slots, sums, hierarchical, .. } = scratch;
        let mut ended = |stage: Stage, n: usize| {
            if let Some(observer) = observer {
                observer(stage, n);
            }
        };
        let n = samples.len;
        ended(Stage::March, n);
        stats.samples += n as u64;
        let output = if round == Round::Coarse { Output::Density } else { Output::Channels };
        evaluate(simd.level(), field, output, samples, work, &mut ended);
        let padded = n.next_multiple_of(LANES);
        hierarchical.lengths[n..padded].fill(0.0);
        let own = Lengths::Each(&hierarchical.lengths[..padded], 1.0);
        opacities(simd, &mut work.output[..padded], own);
        let row_len = sums_len(field.channels());
        for (s, run) in slots.runs[..n].iter().enumerate() {
            let (ray, i) = (run >> NUMBER_BITS, run & ((1 << NUMBER_BITS) - 1));
            let (ray, i, alpha) = (ray as usize, i as usize, work.output[s]);
            if round == Round::Coarse {
                rows(hierarchical.rays, self.row, ray)[1][i] = alpha;
                continue;
            }
            let mut slot = RaySlot::load(&slots.rays[ray]);
            let weight = slot.accumulated.add(alpha, samples.t[s]);
            slot.store(&mut slots.rays[ray]);
            // What has no weight may be no number.
            if weight > 0.0 {
                let sums = &mut sums[ray * row_len + 1..][..field.channels()];
                for (c, sum) in (1..).zip(sums) {
                    *sum += weight * work.output[c * work.stride + s];
                }
            }
        }
        ended(Stage::Composite, n);
        samples.len = 0;
    }
}

/// The two rows of `len` values that are kept of a ray.
fn rows(all: &mut [f32], len: usize, ray: usize) -> [&mut [f32]; 2] {
    all[2 * len * ray..][..2 * len].split_at_mut(len).into()
}

/// How much farther along a ray than along the camera's axis.
fn stretch(axis: [f32; 3], direction: [f32; 3]) -> f32 {
    let cosine = axis[0] * direction[0] + axis[1] * direction[1] + axis[2] * direction[2];
    // Cameras that see behind themselves measure along rays there.
    if cosine > 1e-3 { 1.0 / cosine } else { 1.0 }
}
