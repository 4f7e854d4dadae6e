//! The samples that a step takes against those that the marcher finds.

use fearless_simd::{Level, dispatch};
use pocketnerf_core::Ray;
use pocketnerf_core::march::{Marcher, RayPacket, RayQueue, RayState, SampleBatch};

use super::*;
use crate::trainer::TrainingRay;

/// A ray on its own.
struct Alone(RayState);

impl RayQueue for Alone {
    fn next_samples(&mut self, _: usize, room: usize) -> (RayState, usize) {
        (self.0, room)
    }

    fn advance(&mut self, _: usize, walk: &RayState, _: std::ops::Range<usize>) {
        self.0 = *walk;
    }

    fn skip_to(&mut self, _: usize, next: f32) {
        self.0.next = next;
    }

    fn public(&self, _: usize) -> Ray {
        Ray { origin: self.0.origin, direction: self.0.direction }
    }

    fn turn(&mut self, _: usize, _: &RayState) {
        unreachable!("rays are straight in a box");
    }
}

/// Unit coordinates of all samples along a ray.
fn found(marcher: &Marcher<'_>, ray: &TrainingRay) -> Vec<[f32; 3]> {
    let mut samples = Vec::new();
    let mut packet = RayPacket::EMPTY;
    packet.set(0, &ray.ray, ray.phase);
    let mut rows = [[0.0; 64]; 4];
    dispatch!(Level::baseline(), simd => {
        marcher.enter(simd, &mut packet);
        let (mut ray, mut active) = (Alone(packet.state(0)), vec![0]);
        while !active.is_empty() {
            let [x, y, z, t] = &mut rows;
            let points = [&mut x[..], y, z];
            let directions = [&mut [][..], &mut [], &mut []];
            let mut batch = SampleBatch { points, directions, t, capacity: 64, len: 0, directed: false };
            let alive = marcher.gather(simd, &mut ray, &mut active, &mut batch);
            active.truncate(alive);
            samples.extend((0..batch.len).map(|s| [0, 1, 2].map(|a| batch.points[a][s])));
        }
    });
    samples
}

/// That all rays of a step, which takes no long steps, took what the marcher finds,
/// from the first sample to the last or until they became opaque.
pub(super) fn check<E: Exact + Copy>(step: &Step<E>) {
    let Step { grid, space, sampling, .. } = step;
    let marcher = Marcher::from_parts(Some(grid.view()), *space, *sampling, true);
    for (ray, samples) in step.groups().flat_map(Group::rays_with_samples) {
        let found = found(&marcher, &ray);
        let taken: Vec<_> = samples.iter().map(|(sample, _)| sample.point).collect();
        assert!(samples.iter().all(|(sample, _)| sample.steps == 1.0));
        assert_eq!(taken, found[..taken.len()]);
        let ended = samples.last().is_some_and(|(last, _)| last.transmittance < MIN_TRANSMITTANCE);
        assert!(ended || taken.len() == found.len(), "{} of {}", taken.len(), found.len());
    }
}

/// Where less than 0.6 of the light passes, samples stand for two steps, and for four
/// where a quarter of that does. That they lie in the middle, core's tests know.
#[test]
fn late_samples_stand_for_several_steps() {
    let case =
        Case { encoding: hash_grid(2), log_density: 1.25, coarse_step_below: 0.6, ..ONE_LAYER };
    let mut step = Step::new(case);
    step.run(0.0, 0);
    let mut counts = [0; 5];
    for (_, samples) in step.groups().flat_map(Group::rays_with_samples) {
        assert!(samples.windows(2).all(|pair| pair[0].0.steps <= pair[1].0.steps));
        samples.iter().for_each(|(sample, _)| counts[sample.steps as usize] += 1);
    }
    assert!([1, 2, 4].iter().all(|n| counts[*n] > 100), "{counts:?}");
    assert_eq!(counts.iter().sum::<usize>(), counts[1] + counts[2] + counts[4]);
}
