//! Colours between the training views: held to what the nearest ones see.
//!
//! A colour network that is sharp enough for highlights may show one from a direction that no
//! photograph has: a unit that is silent from all training directions of a point switches on
//! between them, and nothing in the error tells it not to. So a few surface points are asked
//! for their colour from such a direction, and from the cameras around it: what is brighter or
//! darker than all of these by more than a margin is an error of the colour network.

use glam::Vec3;
use pocketnerf_core::Camera;

use super::group::{BATCH, Group, STRIDE, Worker};
use crate::field::Back;
use crate::trainer::pixels::neighbours::{FEWEST, nearest, reach, turn};

/// One ray in so many is asked.
const EVERY: usize = 16;
/// Rays of less opacity meet no surface.
const OPAQUE: f32 = 0.9;
/// Cameras around a direction.
const AROUND: usize = 4;
/// What is asked of a point: a direction between, and those cameras.
const ASKED: usize = 1 + AROUND;
/// A channel may leave what they see by so much.
const MARGIN: f32 = 0.1;
/// Weight of the error beyond, beside that of a ray.
const WEIGHT: f32 = 2.0;

impl Group {
    /// Adds the gradient of the colour network. Features have none: they belong to what is seen.
    pub(super) fn hold_between_views(
        &mut self,
        hits: &[usize],
        channels: usize,
        cameras: &[Camera],
        worker: &mut Worker,
        back: &mut dyn Back,
    ) {
        if cameras.len() < FEWEST {
            return;
        }
        let Worker { features, directions, d_colors, .. } = worker;
        let (mut features_asked, mut directions_asked) = (Vec::new(), Vec::new());
        let Some(random) = &mut self.random else { return };
        let first = random.below(EVERY);
        for (column, &r) in hits.iter().enumerate().skip(first).step_by(EVERY) {
            let (ray, accumulated) = (&self.rays[r].ray, &self.accumulated[r]);
            if accumulated.opacity < OPAQUE {
                continue;
            }
            let direction = Vec3::from(ray.direction);
            let point = Vec3::from(ray.origin) + accumulated.expected_depth() * direction;
            let between = turn(direction, reach(cameras, point, direction), random);
            let Some(around) = nearest::<AROUND>(cameras, point, between) else { return };
            let row = features.chunks(STRIDE).take(channels).map(|row| row[column]);
            features_asked.extend(row);
            directions_asked.push(between);
            directions_asked.extend(around);
        }
        let n = directions_asked.len();
        let padded = n.next_multiple_of(32);
        debug_assert!(padded <= BATCH, "{ASKED} of {EVERY}");
        let rows = features.chunks_mut(STRIDE).chain(d_colors.chunks_mut(STRIDE));
        for row in rows.chain(directions.iter_mut().map(|row| &mut row[..])) {
            row[..padded].fill(0.0);
        }
        for (column, direction) in directions_asked.iter().enumerate() {
            let own = &features_asked[column / ASKED * channels..][..channels];
            for (row, value) in features.chunks_mut(STRIDE).zip(own) {
                row[column] = *value;
            }
            for (row, value) in directions.iter_mut().zip(direction.to_array()) {
                row[column] = value;
            }
        }
        let colors = back.colors(features, directions.each_ref().map(|row| &row[..]), padded);
        for (colors, d_colors) in colors.chunks(STRIDE).zip(d_colors.chunks_mut(STRIDE)).take(3) {
            let asked = colors[..n].chunks_exact(ASKED);
            for (asked, d) in asked.zip(d_colors.chunks_exact_mut(ASKED)) {
                d[0] = WEIGHT * beyond(asked);
            }
        }
        back.colors_back(d_colors, padded);
    }
}

/// By how much the first value leaves what the others span.
fn beyond(values: &[f32]) -> f32 {
    let Some((own, others)) = values.split_first() else { return 0.0 };
    let low = others.iter().copied().fold(f32::INFINITY, f32::min) - MARGIN;
    let high = others.iter().copied().fold(f32::NEG_INFINITY, f32::max) + MARGIN;
    // Of a span with NaN in it nothing is known.
    if low <= high { own - own.clamp(low, high) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::march::composite::Accumulated;
    use pocketnerf_core::scratch::Limits;

    use super::*;
    use crate::dataset::View;
    use crate::random::Random;
    use crate::trainer::pixels::neighbours::tests::at;
    use crate::trainer::pixels::rays::{Backdrop, RaySource};

    #[test]
    fn only_what_leaves_the_span_is_an_error() {
        assert_eq!(beyond(&[0.5, 0.4, 0.6, 0.5, 0.5]), 0.0);
        assert_eq!(beyond(&[0.69, 0.4, 0.6, 0.5, 0.5]), 0.0);
        assert!((beyond(&[0.9, 0.4, 0.6, 0.5, 0.5]) - 0.2).abs() < 1e-6);
        assert!((beyond(&[0.1, 0.4, 0.6, 0.5, 0.5]) + 0.2).abs() < 1e-6);
        assert_eq!(beyond(&[]), 0.0);
    }

    /// A colour network that is bright wherever no camera is, and notes what comes back.
    struct BrightBetween {
        cameras: Vec<Vec3>,
        asked: Vec<Vec3>,
        colors: Vec<f32>,
        gradient: Vec<f32>,
    }

    impl BrightBetween {
        fn is_between(&self, direction: Vec3) -> bool {
            self.cameras.iter().all(|own| own.angle_between(direction) > 0.03)
        }
    }

    impl Back for BrightBetween {
        fn colors(&mut self, _: &[f32], directions: [&[f32]; 3], n: usize) -> &[f32] {
            self.asked = (0..n).map(|i| Vec3::from(directions.map(|row| row[i]))).collect();
            self.colors = vec![0.5; 3 * STRIDE];
            for (i, direction) in self.asked.iter().enumerate() {
                self.colors[i] = f32::from(u8::from(self.is_between(*direction)));
            }
            &self.colors
        }

        fn colors_back(&mut self, d_colors: &[f32], _: usize) -> &[f32] {
            self.gradient = d_colors.to_vec();
            &[]
        }

        fn samples(&mut self, _: &crate::field::SampleGradients<'_>) {}
    }

    #[test]
    fn what_is_bright_between_the_cameras_only_is_an_error() {
        let views = (0..8).map(|i| View::new("", at(10.0 * i as f32), vec![255; 4])).collect();
        let source = RaySource::new(views, Backdrop::Random);
        let mut random = Random::new(1, [0; 3]);
        let seen = Accumulated { opacity: 1.0, transmittance: 0.0, depth: 4.0 };
        let mut group = Group {
            rays: (0..320).map(|_| source.draw_anywhere(false, &mut random)).collect(),
            accumulated: vec![seen; 320],
            random: Some(random),
            ..Group::default()
        };
        let directions = source.cameras().iter().map(|c| -Vec3::from(c.position()).normalize());
        let mut network = BrightBetween {
            cameras: directions.collect(),
            asked: Vec::new(),
            colors: Vec::new(),
            gradient: Vec::new(),
        };
        let limits = Limits { width: 16, rows: [16; 2], channels: 4, ray_samples: 0 };
        let hits: Vec<usize> = (0..320).collect();
        let mut worker = Worker::new(limits);
        group.hold_between_views(&hits, 4, source.cameras(), &mut worker, &mut network);
        let mut held = 0;
        for (i, direction) in network.asked.iter().enumerate().take(320 / EVERY * ASKED) {
            let between = network.is_between(*direction);
            assert!(i % ASKED == 0 || !between, "the others are cameras");
            let expected = if between { WEIGHT * (1.0 - MARGIN) } else { 0.0 };
            assert!((network.gradient[i] - expected).abs() < 1e-5, "{i}");
            assert_eq!([1, 2].map(|c| network.gradient[c * STRIDE + i]), [0.0; 2]);
            held += u32::from(between);
        }
        assert!(held > 5, "{held}");
    }
}
