//! Marching through occupied cells: every sample of the global grid that lies
//! in an occupied cell, and no other.
//!
//! The positions are those that visiting every step and testing every bit
//! would give; empty cells and blocks are crossed in one stride each, which is
//! rounded down so that it never passes a sample of the next cell.

use crate::occupancy::BLOCK;
use crate::sampler::MAX_STEPS;
use crate::space::UnitMap;
use crate::{Model, Occupancy, Ray, Sampling, Space};

/// What marching needs of a model.
#[derive(Clone, Copy, Debug)]
pub struct Marcher<'a> {
    occupancy: Option<Occupancy<'a>>,
    space: Space,
    map: UnitMap,
    sampling: Sampling,
    skip: bool,
}

/// A ray and the steps it still has to take.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// The ray.
    pub ray: Ray,
    /// Number of the next step.
    pub next: u32,
    /// One past the last step inside the box.
    pub end: u32,
    /// Where in its step a sample lies: 0.5 is the middle.
    pub phase: f32,
}

impl Path {
    /// Whether there are steps left.
    #[inline(always)]
    #[must_use]
    pub const fn is_alive(&self) -> bool {
        self.next < self.end
    }
}

impl<'a> Marcher<'a> {
    /// Marches through `model`; without `skip`, every step is visited and
    /// tested on its own, which gives the same samples more slowly.
    #[must_use]
    pub fn new(model: &Model<'a>, skip: bool) -> Self {
        Self::from_parts(model.occupancy, model.space, model.sampling, skip)
    }

    /// The same, from the parts of a model that matter.
    #[must_use]
    pub fn from_parts(
        occupancy: Option<Occupancy<'a>>,
        space: Space,
        sampling: Sampling,
        skip: bool,
    ) -> Self {
        Self { occupancy, space, map: space.unit_map(), sampling, skip }
    }

    /// Distance of step `k` along a ray whose steps are shifted by `phase`
    /// steps: 0.5 when rendering, random when training.
    #[inline(always)]
    #[must_use]
    pub fn distance(&self, k: u32, phase: f32) -> f32 {
        self.sampling.near + (k as f32 + phase) * self.sampling.step
    }

    #[inline(always)]
    fn point(ray: &Ray, t: f32) -> [f32; 3] {
        let (o, d) = (ray.origin, ray.direction);
        [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]
    }

    /// The steps of `ray` whose samples, at `phase` (0 to 1) of each, the space
    /// [contains](Space::contains). Rounding along a ray goes one way, so that
    /// none is missing between the first and the last.
    #[must_use]
    pub fn path(&self, ray: Ray, phase: f32) -> Path {
        let Sampling { step, near, far, .. } = self.sampling;
        let Some([t0, t1]) = self.space.reach(&ray, near, far) else {
            return Path { ray, next: 0, end: 0, phase };
        };
        // Start a little outside, then move in. `as` saturates and takes NaN to 0.
        let inside = |k: u32| {
            let t = self.distance(k, phase);
            t <= far && self.space.contains(Self::point(&ray, t))
        };
        let mut next = (((t0 - near) / step) as u32).saturating_sub(2);
        let mut end = (((t1 - near) / step) as u32).saturating_add(3).min(MAX_STEPS);
        while next < end && !inside(next) {
            next += 1;
        }
        while next < end && !inside(end - 1) {
            end -= 1;
        }
        Path { ray, next, end, phase }
    }

    /// Takes up to `most` occupied samples from `path`, nearest first: calls
    /// `emit(t, u)` with the distance and the unit coordinates of each.
    #[inline(always)]
    pub fn advance(&self, path: &mut Path, most: usize, mut emit: impl FnMut(f32, [f32; 3])) {
        let Path { ray, next: mut k, end, phase } = *path;
        let mut left = most;
        let Some(occupancy) = &self.occupancy else {
            while k < end && left > 0 {
                let t = self.distance(k, phase);
                emit(t, self.map.apply(Self::point(&ray, t)));
                k += 1;
                left -= 1;
            }
            path.next = k;
            return;
        };
        let stride = Stride::new(&ray, &self.map, &self.sampling);
        let cells = occupancy.resolution() as f32;
        while k < end && left > 0 {
            let t = self.distance(k, phase);
            let u = self.map.apply(Self::point(&ray, t));
            // Inside the box u ≥ 0; a negative rounding error saturates to 0.
            let cell = [(u[0] * cells) as u32, (u[1] * cells) as u32, (u[2] * cells) as u32];
            let block = cell.map(|c| c / BLOCK);
            match occupancy.block(block[0], block[1], block[2]) {
                None => {
                    k += if self.skip {
                        stride.steps_to_leave(u, block, (BLOCK as f32) / cells, t)
                    } else {
                        1
                    };
                }
                Some(bits) => {
                    let [x, y, z] = cell.map(|c| c % BLOCK);
                    if bits[(y + BLOCK * z) as usize] >> x & 1 == 1 {
                        emit(t, u);
                        k += 1;
                        left -= 1;
                    } else if self.skip {
                        k += stride.steps_to_leave(u, cell, 1.0 / cells, t);
                    } else {
                        k += 1;
                    }
                }
            }
        }
        path.next = k.min(end);
    }
}

/// How many steps a ray needs to cross a cell.
struct Stride {
    /// Steps per unit length along each axis (infinite where the ray is parallel).
    steps_per_unit: [f32; 3],
    /// 1 where the ray goes up the axis, else 0: which face it leaves through.
    upper: [f32; 3],
    /// Rounding error of a unit coordinate along each axis, in steps: large
    /// where the ray hardly moves along the axis.
    slack: [f32; 3],
    /// Rounding error of a distance, in steps, per unit of distance.
    error: f32,
}

impl Stride {
    fn new(ray: &Ray, map: &UnitMap, sampling: &Sampling) -> Self {
        let steps_per_unit = ray.direction.map(|d| 1.0 / (d * map.scale * sampling.step));
        // A point is a sum of numbers no larger than this, each rounded.
        let rounding = |axis: usize| {
            let most = 1.0 + map.scale * (ray.origin[axis].abs() + map.min[axis].abs());
            4.0 * f32::EPSILON * most
        };
        Self {
            steps_per_unit,
            slack: [0, 1, 2].map(|axis| rounding(axis) * steps_per_unit[axis].abs()),
            upper: ray.direction.map(|d| if d > 0.0 { 1.0 } else { 0.0 }),
            error: 8.0 * f32::EPSILON / sampling.step,
        }
    }

    /// Steps to the first sample beyond the cube `cell` of side `side` around
    /// unit point `u`, or a little less; at least 1.
    #[inline(always)]
    fn steps_to_leave(&self, u: [f32; 3], cell: [u32; 3], side: f32, t: f32) -> u32 {
        let along = |axis: usize| {
            let face = (cell[axis] as f32 + self.upper[axis]) * side;
            let steps = (face - u[axis]) * self.steps_per_unit[axis] - self.slack[axis];
            // Parallel rays give ±infinity or NaN, and never leave. A negative number
            // means that rounding put `u` on the far side: one step, no more.
            if steps.is_finite() { steps } else { f32::INFINITY }
        };
        let steps = along(0).min(along(1)).min(along(2));
        let safe = steps - (0.01 + self.error * t);
        // Whole steps, rounded up: the last sample inside is `floor(steps)` away.
        if safe > 0.0 && safe < 1e6 { (safe as u32) + 1 } else { 1 }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn samples(marcher: &Marcher<'_>, ray: Ray, most: usize) -> Vec<u32> {
        let mut path = marcher.path(ray, 0.5);
        let mut all = Vec::new();
        while path.next < path.end {
            marcher.advance(&mut path, most, |t, _| all.push(t.to_bits()));
        }
        all
    }

    /// A little random grid; deterministic.
    fn random(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) as f32 / (1 << 24) as f32
    }

    #[test]
    fn skipping_finds_the_same_samples() {
        let mut state = 7;
        let n_blocks = 4usize;
        let mut coarse = vec![0u8; n_blocks.pow(3) * 2];
        let mut fine = Vec::new();
        for block in coarse.as_chunks_mut::<2>().0 {
            if random(&mut state) < 0.4 {
                fine.push([0u8; 64].map(|_| {
                    ((random(&mut state) * 256.0) as u8) & ((random(&mut state) * 256.0) as u8)
                }));
                *block = (fine.len() as u16).to_le_bytes();
            }
        }
        let occupancy = Occupancy::new(32, 1, &coarse, fine.as_flattened()).unwrap();
        let space = Space::Box { min: [-1.0, -1.5, -1.0], max: [1.0, 1.5, 0.5] };
        let sampling = Sampling { step: 0.007, near: 0.3, far: 9.0, min_transmittance: 1e-3 };
        let mut found = 0;
        for i in 0..600 {
            let mut axis = || random(&mut state) * 2.0 - 1.0;
            let mut direction = [axis(), axis(), axis()];
            if i % 5 == 0 {
                direction[i % 3] = 0.0;
            }
            if i % 7 == 0 {
                direction = [0.0, 0.0, -1.0];
            }
            let norm = crate::math::sqrt(direction.iter().map(|d| d * d).sum::<f32>());
            let direction = direction.map(|d| d / norm);
            let target = [axis(), axis() * 1.5, axis()];
            let far = if i % 11 == 0 { 0.5 } else { 4.0 };
            let origin = [0, 1, 2].map(|a| target[a] - far * direction[a]);
            let ray = Ray { origin, direction };
            let slow = Marcher::from_parts(Some(occupancy), space, sampling, false);
            let fast = Marcher::from_parts(Some(occupancy), space, sampling, true);
            let expected = samples(&slow, ray, 1000);
            assert_eq!(expected, samples(&fast, ray, 5), "ray {i}: {ray:?}");
            found += expected.len();
            // The slow way itself, by its definition.
            let all = (0..1300u32).map(|k| slow.distance(k, 0.5)).filter(|&t| {
                let p = Marcher::point(&ray, t);
                t < 9.0 && space.contains(p) && occupancy.at(space.unit_map().apply(p))
            });
            assert!(all.map(f32::to_bits).eq(expected.iter().copied()), "ray {i}");
        }
        assert!(found > 5000, "the test saw {found} samples");
    }

    #[test]
    fn odd_rays_end() {
        let occupancy = Occupancy::new(8, 1, &[0, 0], &[]).unwrap();
        let space = Space::Box { min: [0.0; 3], max: [1.0; 3] };
        let sampling = Sampling { step: 1e-3, near: 0.0, far: 1e3, min_transmittance: 0.0 };
        let marcher = Marcher::from_parts(Some(occupancy), space, sampling, true);
        let odd = [0.0, -0.0, 1e-39, 1e-12, 1.0, -1.0, f32::NAN, f32::INFINITY, 1e30];
        for &a in &odd {
            for &b in &odd {
                for origin in [[0.0; 3], [0.5; 3], [1.0; 3], [a, 0.5, b]] {
                    assert!(
                        samples(&marcher, Ray { origin, direction: [a, b, 0.3] }, 4).is_empty()
                    );
                }
            }
        }
    }
}
