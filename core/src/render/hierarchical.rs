//! Pictures as the paper makes them: samples spread along all of a ray, more of them
//! where those have weight, all of them added up.
//!
//! Some rays travel together, so that batches are full: one round through the coarse
//! field, one through the fine one.

use fearless_simd::{Simd, SimdBase};

use crate::field::{Field, Samples};
use crate::lanes;
use crate::march::hierarchical::{ENDLESS, evenly, inverse_cdf, merge, weights};
use crate::march::{Hierarchical, LANES, RayPacket, RayState, Reach};
use crate::render::driver::Job;
use crate::render::flight::Flight;
use crate::render::group::Group;
use crate::render::observe::Stage;
use crate::render::source::Source;
use crate::render::target::Target;
use crate::scratch::{Scratch, sums_len};
use crate::space::UnitMap;
use crate::{Occupancy, Ray, Sampling, Space};

/// Bits of a sample's number within its ray: no ray has more than 2048.
const NUMBER_BITS: u32 = 11;
/// Renders every pixel.
pub(super) fn each_pixel<S: Simd, F: Field>(
    simd: S,
    [coarse, fine]: [&F; 2],
    hierarchical: &Hierarchical,
    group: &mut Group<'_, '_, '_, '_>,
    job: &Job<'_, impl Source + ?Sized>,
    target: &mut Target<'_>,
) {
    let rays = Rays::new(hierarchical, group, job);
    let size = target.size;
    let mut pixels = job.span.passes(size).flat_map(|pass| pass.pixels());
    loop {
        let (mut numbers, mut n) = ([0; LANES], 0);
        let room = LANES.min(rays.most - group.count);
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
        group.rays += n as u64;
        let mut packet = RayPacket::EMPTY;
        job.source.fill(simd, &numbers[..n], &mut packet);
        for (lane, number) in numbers[..n].iter().enumerate() {
            match rays.reach(&mut packet, lane) {
                Some(reach) => {
                    let flight = Flight::start(&packet, lane, *number);
                    flight.store(&mut group.scratch.rays[group.count]);
                    rays.spread(group, reach);
                    group.count += 1;
                }
                None => target.clear(*number),
            }
        }
        group.ended(Stage::Aim, n);
        if group.count == rays.most || n < room {
            let count = group.count;
            group.scratch.sums[..count * sums_len(fine.channels())].fill(0.0);
            // Here, whether the field was asked along a ray.
            group.scratch.active[..count].fill(0.0);
            if hierarchical.n_fine > 0 {
                rays.round::<S, F>(simd, coarse, group, Round::Coarse);
                rays.draw(group);
            }
            rays.round::<S, F>(simd, fine, group, Round::Fine);
            group.hits +=
                group.scratch.active[..count].iter().filter(|asked| **asked > 0.0).count() as u64;
            group.finish(simd, fine.deferred(), job.source, target);
            group.ended(Stage::Shade, count);
        }
        if n < room {
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

/// Rays' samples, and where they may be.
struct Rays<'m> {
    hierarchical: Hierarchical,
    clipped: bool,
    /// Direction along which `near` and `far` are measured, if not along rays.
    axis: Option<[f32; 3]>,
    space: Space,
    map: UnitMap,
    occupancy: Option<Occupancy<'m>>,
    sampling: Sampling,
    /// Rays that travel together at most.
    most: usize,
    /// Most samples of a batch.
    batch: usize,
    /// Values kept of a ray's samples.
    row: usize,
}

impl<'m> Rays<'m> {
    fn new(
        hierarchical: &Hierarchical,
        group: &Group<'m, '_, '_, '_>,
        job: &Job<'_, impl Source + ?Sized>,
    ) -> Self {
        let (model, limits) = (group.model, job.options.limits);
        Self {
            hierarchical: *hierarchical,
            clipped: hierarchical.reach == Reach::Clipped,
            axis: job.source.axis().filter(|_| hierarchical.reach == Reach::Depth),
            space: model.space,
            map: model.space.unit_map(),
            occupancy: model.occupancy,
            sampling: model.sampling,
            most: limits.hierarchical_rays(group.tuning),
            batch: group.tuning.samples,
            row: limits.ray_samples,
        }
    }

    /// Takes the ray in a lane to local coordinates, and says between which distances it
    /// has its samples.
    fn reach(&self, packet: &mut RayPacket, lane: usize) -> Option<[f32; 2]> {
        let Sampling { near, far, .. } = self.sampling;
        let [origin, direction] =
            [&packet.origin, &packet.direction].map(|rows| [0, 1, 2].map(|a| rows[a][lane]));
        let local = self.space.local(&Ray { origin, direction })?;
        packet.set(lane, &local, 0.5);
        if self.clipped {
            return self.space.intersect(&local, near, far);
        }
        if let Some(length) = self.space.whole_way(&local) {
            return Some([0.0, length]);
        }
        let stretch = self.axis.map_or(1.0, |axis| stretch(axis, direction));
        Some([near, far].map(|depth| depth * stretch))
    }

    /// Spreads the samples of the next ray evenly.
    fn spread(&self, group: &mut Group<'_, '_, '_, '_>, [near, far]: [f32; 2]) {
        let n = self.hierarchical.n_coarse as usize;
        // Without a second round, these are the picture's.
        let which = if self.hierarchical.n_fine > 0 { 0 } else { 1 };
        evenly(near, far, &mut self.rows(group, group.count)[which][..n]);
    }

    /// Of a ray: distances of the first round, later free; its opacities, then the
    /// distances of the second.
    fn rows<'g>(&self, group: &'g mut Group<'_, '_, '_, '_>, ray: usize) -> [&'g mut [f32]; 2] {
        let own = &mut group.scratch.hierarchical.rays[2 * self.row * ray..][..2 * self.row];
        own.split_at_mut(self.row).into()
    }

    /// Draws distances from the opacities of the first round.
    fn draw(&self, group: &mut Group<'_, '_, '_, '_>) {
        let Hierarchical { n_coarse, n_fine, .. } = self.hierarchical;
        let (n, last) = (n_coarse as usize, n_fine.max(2) - 1);
        let mut found = core::mem::take(&mut group.scratch.hierarchical.found);
        for ray in 0..group.count {
            let [first, all] = self.rows(group, ray);
            weights(&mut all[..n]);
            let found = &mut found[..n_fine as usize];
            inverse_cdf(&first[..n], &all[..n], |i| i as f32 / last as f32, found);
            merge(&first[..n], found, &mut all[..self.hierarchical.n_all()]);
        }
        core::mem::swap(&mut group.scratch.hierarchical.found, &mut found);
    }

    /// Asks the field for all samples of all rays.
    fn round<S: Simd, F: Field>(
        &self,
        simd: S,
        field: &F,
        group: &mut Group<'_, '_, '_, '_>,
        round: Round,
    ) {
        let n = match round {
            Round::Coarse => self.hierarchical.n_coarse as usize,
            Round::Fine => self.hierarchical.n_all(),
        };
        // Where samples end where the ray leaves the space, the last stands for nothing.
        let last = if self.clipped { 0.0 } else { ENDLESS };
        let mut waiting = 0;
        for ray in 0..group.count {
            let walk = Flight::load(&group.scratch.rays[ray]).walk;
            let direction = walk.public_direction(&self.space);
            for i in 0..n {
                let Scratch { points, directions, t, runs, active, hierarchical, .. } =
                    &mut group.scratch;
                let distances =
                    hierarchical.rays[2 * self.row * ray..][..2 * self.row].split_at_mut(self.row);
                let (distances, opacities) = match round {
                    Round::Coarse => (&distances.0[..n], Some(distances.1)),
                    Round::Fine => (&distances.1[..n], None),
                };
                let at = distances[i];
                let Some(u) = self.place(&walk, at) else {
                    if let Some(opacities) = opacities {
                        opacities[i] = 0.0;
                    }
                    continue;
                };
                for (row, u) in points.iter_mut().zip(u) {
                    row[waiting] = u;
                }
                for (row, d) in directions.iter_mut().zip(direction) {
                    row[waiting] = d;
                }
                t[waiting] = at;
                hierarchical.deltas[waiting] = distances.get(i + 1).map_or(last, |next| next - at);
                runs[waiting] = f32::from_bits((ray << NUMBER_BITS | i) as u32);
                active[ray] = 1.0;
                waiting += 1;
                if waiting == self.batch {
                    self.ask::<S, F>(simd, field, group, round, waiting);
                    waiting = 0;
                }
            }
        }
        if waiting > 0 {
            self.ask::<S, F>(simd, field, group, round, waiting);
        }
    }

    /// The unit coordinates of a ray's sample; `None` where the field is not asked.
    #[inline(always)]
    fn place(&self, walk: &RayState, t: f32) -> Option<[f32; 3]> {
        let (o, d) = (walk.origin, walk.direction);
        let p = [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]];
        let u = self.map.apply(p);
        let occupied = || self.occupancy.is_none_or(|occupancy| occupancy.at(u));
        (!self.clipped || (self.space.contains(p) && occupied())).then_some(u)
    }

    /// Asks the field for the samples that wait.
    fn ask<S: Simd, F: Field>(
        &self,
        simd: S,
        field: &F,
        group: &mut Group<'_, '_, '_, '_>,
        round: Round,
        n: usize,
    ) {
        group.ended(Stage::March, n);
        group.samples += n as u64;
        let padded = n.next_multiple_of(LANES);
        let Scratch { work, points, directions, .. } = &mut group.scratch;
        for row in points.iter_mut().chain(directions.iter_mut()) {
            row[n..padded].fill(0.0);
        }
        field.encode(simd, [0, 1, 2].map(|axis| &points[axis][..padded]), work);
        group.ended(Stage::Encode, n);
        let Scratch { work, points, directions, .. } = &mut group.scratch;
        let samples = Samples {
            points: [0, 1, 2].map(|axis| &points[axis][..padded]),
            directions: [0, 1, 2].map(|axis| &directions[axis][..padded]),
        };
        field.decode(simd, samples, work);
        group.ended(Stage::Density, n);
        let Scratch { work, t, runs, rays, sums, hierarchical, .. } = &mut group.scratch;
        hierarchical.deltas[n..padded].fill(0.0);
        opacities(simd, &mut work.output[..padded], &hierarchical.deltas[..padded]);
        let row_len = sums_len(field.channels());
        for (s, run) in runs[..n].iter().enumerate() {
            let (ray, i) = (run.to_bits() >> NUMBER_BITS, run.to_bits() & ((1 << NUMBER_BITS) - 1));
            let (ray, i, alpha) = (ray as usize, i as usize, work.output[s]);
            if round == Round::Coarse {
                hierarchical.rays[(2 * ray + 1) * self.row + i] = alpha;
                continue;
            }
            let mut flight = Flight::load(&rays[ray]);
            let weight = flight.accumulated.add(alpha, t[s]);
            flight.store(&mut rays[ray]);
            // What has no weight may be no number.
            if weight > 0.0 {
                let sums = &mut sums[ray * row_len + 1..][..field.channels()];
                for (c, sum) in (1..).zip(sums) {
                    *sum += weight * work.output[c * work.stride + s];
                }
            }
        }
        group.ended(Stage::Composite, n);
    }
}

/// How much farther along a ray than along the camera's axis.
fn stretch(axis: [f32; 3], direction: [f32; 3]) -> f32 {
    let cosine = axis[0] * direction[0] + axis[1] * direction[1] + axis[2] * direction[2];
    // Cameras that see behind themselves measure along rays there.
    if cosine > 1e-3 { 1.0 / cosine } else { 1.0 }
}

/// Turns densities into opacities in place, each standing for its part of the ray.
fn opacities<S: Simd>(simd: S, sigma: &mut [f32], deltas: &[f32]) {
    simd.vectorize(
        #[inline(always)]
        || {
            let n = S::f32s::LEN;
            for (sigma, delta) in sigma.chunks_exact_mut(n).zip(deltas.chunks_exact(n)) {
                let optical = S::f32s::from_slice(simd, sigma) * -S::f32s::from_slice(simd, delta);
                (S::f32s::splat(simd, 1.0) - lanes::exp(simd, optical)).store_slice(sigma);
            }
        },
    );
}
