extern crate std;
use std::vec;
use std::vec::Vec;

use fearless_simd::dispatch;

use super::*;
use crate::march::{RUN, RayQueue, RayState, SampleBatch};
use crate::{Ray, SimdLevel};

/// Rays that note the distances of their samples.
struct Noting {
    states: Vec<RayState>,
    most: usize,
    /// Whose each sample of the batch is.
    owners: Vec<usize>,
}

impl RayQueue for Noting {
    fn next_samples(&mut self, ray: usize, room: usize) -> (RayState, usize) {
        assert!((1..=RUN).contains(&room));
        (self.states[ray], self.most.min(room))
    }

    fn advance(&mut self, ray: usize, state: &RayState, samples: core::ops::Range<usize>) {
        assert_eq!(samples.start, self.owners.len());
        assert!(samples.len() <= self.most && state.is_active() >= samples.is_empty());
        self.owners.resize(samples.end, ray);
        self.states[ray] = *state;
    }

    fn skip_to(&mut self, ray: usize, next: f32) {
        assert!(next >= self.states[ray].next);
        self.states[ray].next = next;
    }

    fn public(&self, ray: usize) -> Ray {
        let RayState { origin, direction, .. } = self.states[ray];
        Ray { origin, direction }
    }

    fn turn(&mut self, _: usize, _: &RayState) {
        unreachable!("rays are straight in a box");
    }
}

/// The distances of all samples along rays, at most `most` at a time, each for so many
/// steps, in batches of 32 or so.
fn samples(
    marcher: &Marcher<'_>,
    rays: &[Ray],
    (most, steps): (usize, f32),
    simd: SimdLevel,
) -> Vec<Vec<u32>> {
    let mut packet = RayPacket::EMPTY;
    for (lane, ray) in rays.iter().enumerate() {
        packet.set(lane, ray, 0.5);
    }
    packet.steps = [steps; LANES];
    let mut all = vec![Vec::new(); rays.len()];
    dispatch!(simd.token().unwrap(), simd => {
        marcher.enter(simd, &mut packet);
        let states = (0..rays.len()).map(|lane| packet.state(lane)).collect();
        let mut noting = Noting { states, most, owners: Vec::new() };
        let mut active: Vec<u32> = (0..rays.len()).map(|ray| ray as u32).collect();
        let mut rows = [[0.0; 33]; 4];
        while !active.is_empty() {
            let [x, y, z, t] = &mut rows;
            let (points, directions) = ([&mut x[..], y, z], [&mut [][..], &mut [], &mut []]);
            let mut batch = SampleBatch { points, directions, t, capacity: 33, len: 0, directed: false };
            noting.owners.clear();
            let alive = marcher.gather(simd, &mut noting, &mut active, &mut batch);
            active.truncate(alive);
            assert_eq!(noting.owners.len(), batch.len);
            for (s, ray) in noting.owners.iter().enumerate() {
                let t = rows[3][s];
                let at = [0, 1, 2].map(|a| rays[*ray].origin[a] + t * rays[*ray].direction[a]);
                assert_eq!(marcher.map.apply(at), [0, 1, 2].map(|a| rows[a][s]));
                all[*ray].push(t.to_bits());
            }
        }
        assert!(noting.states.iter().all(|state| !state.is_active()));
    });
    all
}

/// The distances of the samples to which seeking takes up to sixteen rays.
fn sought(marcher: &Marcher<'_>, rays: &[Ray], simd: SimdLevel) -> Vec<Option<u32>> {
    let mut packet = RayPacket::EMPTY;
    for (lane, ray) in rays.iter().enumerate() {
        packet.set(lane, ray, 0.5);
    }
    dispatch!(simd.token().unwrap(), simd => {
        marcher.enter(simd, &mut packet);
        marcher.seek(simd, &mut packet);
    });
    let Sampling { step, near, .. } = marcher.sampling;
    (0..rays.len())
        .map(|lane| {
            let (next, end) = (packet.next[lane], packet.end[lane]);
            (next < end).then(|| ((next + 0.5) * step + near).to_bits())
        })
        .collect()
}

/// A little random grid; deterministic.
fn random(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*state >> 8) as f32 / (1 << 24) as f32
}

fn random_ray(i: usize, state: &mut u32) -> Ray {
    let mut axis = || random(state) * 2.0 - 1.0;
    let mut direction = [axis(), axis(), axis()];
    if i.is_multiple_of(5) {
        direction[i % 3] = 0.0;
    }
    if i.is_multiple_of(7) {
        direction = [0.0, 0.0, -1.0];
    }
    let norm = crate::math::sqrt(direction.iter().map(|d| d * d).sum::<f32>());
    let direction = direction.map(|d| d / norm);
    let target = [axis(), axis() * 1.5, axis()];
    let far = if i.is_multiple_of(11) { 0.5 } else { 4.0 };
    Ray { origin: [0, 1, 2].map(|a| target[a] - far * direction[a]), direction }
}

#[test]
fn every_level_finds_the_samples_of_the_definition() {
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
    let slow = Marcher::from_parts(Some(occupancy), space, sampling, false);
    let fast = Marcher::from_parts(Some(occupancy), space, sampling, true);
    let mut table = vec![0; occupancy.table_len()];
    occupancy.write_table(&mut table).unwrap();
    let tabled = occupancy.with_table(&table).unwrap();
    let tabled = Marcher::from_parts(Some(tabled), space, sampling, true);
    let rays: Vec<Ray> = (0..600).map(|i| random_ray(i, &mut state)).collect();
    // Step after step: where the space is, and where something is, the step's sample;
    // then the steps that it stands for are over.
    let definition = |ray: &Ray, steps: f32| {
        let distance = |k: f32| (k + 0.5) * sampling.step + sampling.near;
        let at = |t: f32| [0, 1, 2].map(|a| ray.origin[a] + t * ray.direction[a]);
        let inside = |k: &f32| distance(*k) <= 9.0 && space.contains(at(distance(*k)));
        let within: Vec<f32> = (0..1300).map(|k| k as f32).filter(inside).collect();
        let (mut next, mut found) = (0.0, Vec::new());
        for k in &within {
            let t = distance((k + 0.5 * (steps - 1.0)).min(within[within.len() - 1]));
            if *k >= next && occupancy.at(space.unit_map().apply(at(t))) {
                found.push(t.to_bits());
                next = k + steps;
            }
        }
        found
    };
    let mut found = 0;
    // The last packet is not full.
    for (i, rays) in rays.chunks(LANES).enumerate() {
        let steps = [1.0, 2.0, 1.0, 4.0][i % 4];
        let expected: Vec<Vec<u32>> = rays.iter().map(|ray| definition(ray, steps)).collect();
        found += expected.iter().map(Vec::len).sum::<usize>();
        for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
            assert_eq!(expected, samples(&slow, rays, (4, steps), simd), "{simd:?}");
            assert_eq!(expected, samples(&fast, rays, (3, steps), simd), "{simd:?}");
            assert_eq!(expected, samples(&tabled, rays, (4, steps), simd), "{simd:?}");
            if steps == 1.0 {
                let first: Vec<Option<u32>> = expected.iter().map(|e| e.first().copied()).collect();
                assert_eq!(first, sought(&tabled, rays, simd), "{simd:?}");
            }
        }
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
    let mut rays = Vec::new();
    for &a in &odd {
        for &b in &odd {
            for origin in [[0.0; 3], [0.5; 3], [1.0; 3], [a, 0.5, b]] {
                rays.push(Ray { origin, direction: [a, b, 0.3] });
            }
        }
    }
    for rays in rays.chunks(LANES) {
        for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
            assert!(samples(&marcher, rays, (4, 2.0), simd).iter().all(Vec::is_empty));
        }
    }
}
