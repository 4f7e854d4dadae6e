//! Rays that touch the faces, edges and corners of the box.

use fearless_simd::dispatch;

use super::{Marcher, RayPacket, Sampling};
use crate::{Ray, SimdLevel, Space};

struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }

    fn pick<T: Copy, const N: usize>(&mut self, from: [T; N]) -> T {
        from[(self.unit() * N as f32) as usize]
    }
}

/// A ray that passes a face, an edge or a corner within a few roundings; now
/// and then one that is parallel to faces, or nearly.
fn ray(random: &mut Random, [min, max]: [[f32; 3]; 2], distance: f32) -> Ray {
    let mut direction = [0.0; 3].map(|_: f32| {
        let any = random.unit() * 2.0 - 1.0;
        random.pick([any, any, 0.0, 1e-3 * any, 1e-7 * any, 1e-13 * any, 1e-40])
    });
    if direction.iter().all(|d| d.abs() < 0.1) {
        direction[0] = 1.0;
    }
    let norm = crate::math::sqrt(direction.iter().map(|d| d * d).sum());
    let direction = direction.map(|d| d / norm);
    let origin = [0, 1, 2].map(|axis| {
        let (lo, hi) = (min[axis], max[axis]);
        let anywhere = lo + (hi - lo) * random.unit();
        let target = random.pick([lo, hi, lo.next_down(), hi.next_up(), anywhere, anywhere]);
        let origin = target - distance * direction[axis];
        random.pick([origin, origin, origin.next_up(), origin.next_down()])
    });
    Ray { origin, direction }
}

#[test]
fn a_path_holds_the_steps_that_the_space_contains() {
    let mut random = Random(5);
    let boxes = [
        ([-1.0, -0.75, -1.0], [1.0, 0.75, 0.5]),
        ([0.0; 3], [1.0; 3]),
        ([1000.0, -2000.0, 3.0], [1001.0, -1998.5, 3.25]),
    ];
    // The last: distances are rounded to more than a step.
    let samplings = [(0.0, 6.0, 0.02), (0.3, 4.7, 0.037), (1e6, 1e6 + 2.0, 0.01)];
    let [mut all, mut some, mut none, mut one] = [0; 4];
    for i in 0..30_000 {
        let (min, max) = boxes[i % 3];
        let (near, far, step) = samplings[i / 3 % 3];
        let phase = random.pick([0.5, 0.0, 0.999]);
        let distance = near + random.unit() * (far - near);
        let ray = ray(&mut random, [min, max], distance);
        let space = Space::Box { min, max };
        let sampling = Sampling { step, near, far, min_transmittance: 0.0 };
        let marcher = Marcher::from_parts(None, space, sampling, true);
        let mut packet = RayPacket::EMPTY;
        let lane = i % 16;
        packet.set(lane, &ray, phase);
        let level = random.pick([SimdLevel::Portable, SimdLevel::compiled(), SimdLevel::detect()]);
        dispatch!(level.token().unwrap(), simd => marcher.enter(simd, &mut packet));
        let path = packet.next[lane] as u32..packet.end[lane] as u32;
        let (o, d) = (ray.origin, ray.direction);
        let mut found = 0;
        for k in 0..400 {
            let t = (k as f32 + phase) * step + near;
            let inside = t <= far && space.contains([0, 1, 2].map(|a| o[a] + t * d[a]));
            assert_eq!(path.contains(&k), inside, "step {k} of ray {i}: {ray:?}");
            found += u32::from(inside);
        }
        assert_eq!(found, path.end - path.start);
        match found {
            0 => none += 1,
            1 => one += 1,
            2..100 => some += 1,
            _ => all += 1,
        }
    }
    for seen in [all, some, none, one] {
        assert!(seen > 100, "all {all}, some {some}, none {none}, one {one}");
    }
}
