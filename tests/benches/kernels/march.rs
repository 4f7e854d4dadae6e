//! Rays through a hollow ball in a cube of 128 cells a side.

use std::ops::Range;

use divan::Bencher;
use divan::counter::ItemsCount;
use fearless_simd::dispatch;
use pocketnerf_core::march::{LANES, Marcher, RayPacket, RayQueue, RayState, SampleBatch};
use pocketnerf_core::{Camera, Occupancy, Ray, Sampling, Space};
use pocketnerf_train::trainer::pack;

use crate::synthetic::level;

const CELLS: u32 = 128;
/// Pixels along a side of the picture.
const SIDE: u32 = 64;

fn shell() -> (Vec<u8>, Vec<u8>) {
    let radius = |cell: u32| {
        let at = [cell % CELLS, cell / CELLS % CELLS, cell / (CELLS * CELLS)];
        let squares = at.map(|c| ((c as f32 + 0.5) * 2.0 / CELLS as f32 - 1.0).powi(2));
        squares.iter().sum::<f32>().sqrt()
    };
    pack(CELLS, (0..CELLS * CELLS * CELLS).filter(|cell| (0.6..0.63).contains(&radius(*cell))))
        .unwrap()
}

/// Sixteen neighbours each, a square of the picture.
fn packets() -> Vec<RayPacket> {
    let pose = Camera::look_at([2.5, 1.5, 1.0], [0.0; 3], [0.0, 0.0, 1.0]);
    let camera = Camera::from_fov_x(SIDE, SIDE, 0.7, pose);
    let corner = |i: u32| [i % (SIDE / 4) * 4, i / (SIDE / 4) * 4];
    let packet = |[x, y]: [u32; 2]| {
        let mut packet = RayPacket::EMPTY;
        for lane in 0..LANES as u32 {
            let ray = camera.ray((x + lane % 4) as f32 + 0.5, (y + lane / 4) as f32 + 0.5);
            packet.set(lane as usize, &ray, 0.5);
        }
        packet
    };
    (0..SIDE * SIDE / LANES as u32).map(|i| packet(corner(i))).collect()
}

/// Rays that take what there is.
struct Rays {
    walks: Vec<RayState>,
    most: usize,
}

impl RayQueue for Rays {
    fn next_samples(&mut self, ray: usize, room: usize) -> (RayState, usize) {
        (self.walks[ray], self.most.min(room))
    }

    fn advance(&mut self, ray: usize, walk: &RayState, _: Range<usize>) {
        self.walks[ray] = *walk;
    }

    fn skip_to(&mut self, ray: usize, next: f32) {
        self.walks[ray].next = next;
    }

    fn public(&self, ray: usize) -> Ray {
        let RayState { origin, direction, .. } = self.walks[ray];
        Ray { origin, direction }
    }

    fn turn(&mut self, _: usize, _: &RayState) {
        unreachable!("rays are straight in a box");
    }
}

/// Items are rays; `most`: samples that a ray takes at a time.
#[divan::bench(args = [1, 4])]
fn hollow_ball(bencher: Bencher<'_, '_>, most: usize) {
    let (coarse, fine) = shell();
    let occupancy = Occupancy::new(CELLS, 1, &coarse, &fine).expect("made for it");
    let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
    let sampling = Sampling { step: 2.0 / 350.0, near: 0.0, far: 10.0, min_transmittance: 1e-3 };
    let marcher = Marcher::from_parts(Some(occupancy), space, sampling, true);
    let packets = packets();
    let level = level();
    let mut rows = [[0.0; 1024]; 4];
    bencher.counter(ItemsCount::new(SIDE * SIDE)).bench_local(|| {
        let mut sum = 0.0;
        let mut rays = Rays { walks: Vec::new(), most };
        dispatch!(level, simd => {
            for packet in &packets {
                let mut packet = *packet;
                marcher.enter(simd, &mut packet);
                rays.walks.extend((0..LANES).map(|lane| packet.state(lane)));
            }
            let mut active: Vec<u32> = (0..rays.walks.len() as u32).collect();
            while !active.is_empty() {
                let [x, y, z, t] = rows.each_mut().map(|row| &mut row[..]);
                let (points, directions) = ([x, y, z], [&mut [][..], &mut [], &mut []]);
                let mut batch = SampleBatch { points, directions, t, capacity: 1024, len: 0, directed: false };
                let alive = marcher.gather(simd, &mut rays, &mut active, &mut batch);
                active.truncate(alive);
                sum += batch.len as f32 + batch.points[0][0];
            }
        });
        sum
    });
}
