//! The gradient of poses against central differences of the loss in f64: rays and their samples
//! move with their cameras.

use glam::{DMat3, DQuat, DVec3};

use super::*;
use crate::trainer::poses::{PER_VIEW, Poses};

const TOLERANCE: f64 = 1e-4;
/// How far a difference moves poses.
const MOVE: f64 = 1e-7;

/// Corrections of which all count.
fn corrections(views: usize) -> Vec<f32> {
    let mut random = Random::new(9, [0; 3]);
    (0..PER_VIEW * views).map(|_| 0.2 * (random.next_f32() - 0.5)).collect()
}

/// How the axes of a camera turn in the scene, and where it is, with a correction: turned about a
/// point as far ahead as the middle of the box, then moved, both along its own axes.
fn placed(given: &Camera, own: &[f64], center: DVec3, unit: f64) -> (DMat3, DVec3) {
    let m = given.camera_to_world.map(f64::from);
    let column = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]);
    let (axes, eye) = (DMat3::from_cols(column(0), column(1), column(2)), column(3));
    let turn = axes * DVec3::new(own[0], own[1], own[2]);
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(turn));
    let arm = axes.z_axis * eye.distance(center);
    let shift = axes * DVec3::new(own[3], own[4], own[5]) * unit;
    (turn, eye - arm + turn * arm + shift)
}

/// The error of each derivative, relative to the largest.
fn errors<E: Exact + Copy>(case: Case<E>) -> Vec<f64> {
    let mut step = Step::new(Case { poses: true, ..case });
    let given = step.source.cameras().to_vec();
    let poses = Poses::new(&given, &step.space, 3).unwrap();
    let own = corrections(given.len());
    step.source.move_cameras(poses.cameras(&own));
    step.run(0.0, 0);
    let loss = step.loss();
    let mut pulls = vec![[0.0; PER_VIEW]; given.len()];
    for group in step.groups() {
        let all = pulls.as_flattened_mut().iter_mut().zip(group.pulls.as_flattened());
        all.for_each(|(sum, pull)| *sum += pull);
    }
    let rows = own.as_chunks::<PER_VIEW>().0.iter().zip(&pulls).enumerate();
    let found = rows.flat_map(|(view, (own, pull))| poses.gradient(view, own, pull));
    let found: Vec<f64> = found.map(f64::from).collect();

    let center = DVec3::from(step.space.center().map(f64::from));
    let unit = given.iter().map(|camera| {
        DVec3::from(camera.position().map(f64::from)).distance(center) / given.len() as f64
    });
    let unit: f64 = unit.sum();
    let before: Vec<f64> = own.iter().copied().map(f64::from).collect();
    let all_placed = |own: &[f64]| -> Vec<_> {
        let own = own.chunks(PER_VIEW);
        given.iter().zip(own).map(|(camera, own)| placed(camera, own, center, unit)).collect()
    };
    let old = all_placed(&before);
    let views: Vec<usize> = step.groups().flat_map(Group::views).collect();
    let map = step.space.unit_map();
    let (min, scale) = (DVec3::from(map.min.map(f64::from)), f64::from(map.scale));
    let parameters: Vec<f64> = step.parameters().iter().copied().map(f64::from).collect();
    let moved = |i: usize, by: f64| {
        let mut after = before.clone();
        after[i] += by;
        let new = all_placed(&after);
        let turn = |view: usize| new[view].0 * old[view].0.transpose();
        let point = |r: usize, u: [f64; 3]| {
            let ([(_, from), (_, to)], turn) = ([old[views[r]], new[views[r]]], turn(views[r]));
            let point = to + turn * (min + DVec3::from(u) / scale - from);
            ((point - min) * scale).to_array()
        };
        let direction = |r: usize, d: [f64; 3]| (turn(views[r]) * DVec3::from(d)).to_array();
        loss.moved(point, direction).at(&parameters)
    };
    let expected = |i: usize| (moved(i, MOVE) - moved(i, -MOVE)) / (2.0 * MOVE);
    let expected: Vec<f64> = (0..found.len()).map(expected).collect();
    let most = expected.iter().map(|d| d.abs()).fold(0.0, f64::max);
    assert!(most > 0.1, "{most}");
    found.iter().zip(expected).map(|(found, expected)| (found - expected).abs() / most).collect()
}

#[test]
fn poses_against_differences() {
    for n_features in [1, 2, 4, 8] {
        let case = Case { encoding: hash_grid(n_features), ..ONE_LAYER };
        for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
            let errors = errors(Case { simd: Some(simd), ..case });
            assert!(errors.iter().all(|e| *e < TOLERANCE), "{n_features}: {errors:?}");
        }
    }
    for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
        let errors = errors(Case { simd: Some(simd), ..ONE_LAYER.of(PLANES) });
        assert!(errors.iter().all(|e| *e < TOLERANCE), "planes: {errors:?}");
    }
    // Opaque, and more samples than a batch takes.
    let case = Case { encoding: hash_grid(2), ..ONE_LAYER };
    for case in [Case { log_density: 3.0, ..case }, Case { rays: [2200, 30], ..case }] {
        let errors = errors(case);
        assert!(errors.iter().all(|e| *e < TOLERANCE), "{case:?}: {errors:?}");
    }
}
