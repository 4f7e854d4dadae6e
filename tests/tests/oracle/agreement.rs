//! The same picture as the oracle's, within a tolerance.

use pocketnerf_core::reference::{self, RayResult};
use pocketnerf_core::{Model, Ray, RenderOptions, Sampling, SimdLevel, Space, Tuning};

use crate::models::{Random, Recipe, camera, in_contracted, in_ndc};
use crate::picture::{self, Picture, levels, options, whole};

/// Most that a channel of a pixel may differ, premultiplied and in [0, 1]: a
/// quarter of a step of an 8-bit picture. It covers f32 against f64 and rays
/// that end one sample apart at the transmittance they stop at (1e-4 here).
const CHANNEL: f32 = 1e-3;

/// Root of the mean squared difference of a picture: so little that a PSNR of
/// 40 dB moves by at most 0.02 dB.
const RMS: f64 = 2.3e-5;

/// Most that opacity × depth may differ, scene units: a thirtieth of a step.
const DEPTH: f32 = 1e-3;

#[test]
fn every_kind_of_model_at_every_level() {
    every_kind(|model| model);
}

#[test]
fn every_kind_of_model_in_ndc() {
    every_kind(in_ndc);
}

#[test]
fn every_kind_of_model_in_contracted_space() {
    every_kind(in_contracted);
}

/// Every kind of model, put into a space, at every level.
fn every_kind(in_space: impl Fn(Model<'static>) -> Model<'static>) {
    let camera = camera(33, 17);
    let [mut empty, mut misty, mut opaque] = [0; 3];
    for recipe in Recipe::all() {
        let model = in_space(recipe.build());
        let mut expected = vec![RayResult::EMPTY; 33 * 17];
        reference::render_picture(&model, &camera, &mut expected).unwrap();
        for level in levels() {
            for tuning in [Tuning::SMALL, Tuning::FAST] {
                let options = options(&model, level, tuning);
                let found = picture::tile(&model, &camera, whole(&camera), &options);
                let what = format!("{recipe:?} {:?} {level} {tuning:?}", model.space);
                compare(&model, &found, &expected, &what);
                let unskipped = RenderOptions { skip: false, ..options };
                picture::tile(&model, &camera, whole(&camera), &unskipped)
                    .assert_same(&found, "without skipping");
            }
        }
        empty += expected.iter().filter(|p| p.opacity == 0.0).count();
        misty += expected.iter().filter(|p| (0.1..0.9).contains(&p.opacity)).count();
        opaque += expected.iter().filter(|p| p.opacity > 0.999).count();
    }
    // The models show what there is to get wrong.
    for (what, pixels) in [("empty", empty), ("misty", misty), ("opaque", opaque)] {
        assert!(pixels > 1000, "{pixels} {what} pixels");
    }
}

#[track_caller]
pub(crate) fn compare(model: &Model<'_>, found: &Picture, expected: &[RayResult], what: &str) {
    let mut squares = 0.0;
    for (i, (rgba, expected)) in found.rgba.iter().zip(expected).enumerate() {
        let [r, g, b] = expected.rgb;
        for (a, b) in rgba.iter().zip([r, g, b, expected.opacity]) {
            assert!((a - b).abs() <= CHANNEL, "{what}: pixel {i}: {rgba:?} for {expected:?}");
            squares += f64::from(a - b).powi(2);
        }
        if expected.opacity > 0.0 && rgba[3] > 0.0 {
            // In other spaces steps are even in 1 / depth, about.
            let of = |depth: f32| match model.space {
                Space::Box { .. } => depth,
                _ => 1.0 / depth,
            };
            let apart = (of(found.depth[i]) - of(expected.depth)) * expected.opacity;
            assert!(apart.abs() <= DEPTH, "{what}: depth {i}: {} for {expected:?}", found.depth[i]);
        } else {
            assert!(rgba[3] > 0.0 || found.depth[i] == f32::INFINITY, "{what}: depth {i}");
        }
    }
    let rms = (squares / (4 * expected.len()) as f64).sqrt();
    assert!(rms <= RMS, "{what}: rms {rms:e}");
}

/// The oracle tries every sample of the grid, the renderer those that count.
#[test]
fn the_field_is_evaluated_at_the_same_points() {
    let camera = camera(21, 13);
    let models = [None, Some(16), Some(24)].map(|occupancy| Recipe { occupancy, ..Recipe::PLAIN });
    for mut model in
        models.iter().flat_map(|r| [r.build(), in_ndc(r.build()), in_contracted(r.build())])
    {
        // Nothing is hidden, and the last sample lies at `far` exactly.
        let (step, near, far) = (0.03125, 0.5, 0.5 + 64.5 * 0.03125);
        model.sampling = Sampling { step, near, far, min_transmittance: 0.0 };
        let mut expected = vec![RayResult::EMPTY; 21 * 13];
        reference::render_picture(&model, &camera, &mut expected).unwrap();
        let evaluated: u64 = expected.iter().map(|ray| u64::from(ray.samples)).sum();
        for level in levels() {
            let options = options(&model, level, Tuning::FAST);
            let found = picture::tile(&model, &camera, whole(&camera), &options);
            assert_eq!(found.stats.samples, evaluated, "{:?} {level}", model.space);
            assert_eq!(found.stats.rays, 21 * 13);
        }
    }
}

/// A ray through a face, an edge or a corner, within a rounding or two.
fn touching(random: &mut Random, [min, max]: [[f32; 3]; 2]) -> Ray {
    let mut axis = || [0.0, 1e-9, 1.0, 1.0][(random.unit() * 4.0) as usize] * random.signed();
    let mut direction = [axis(), axis(), axis()];
    if direction.iter().all(|d| d.abs() < 0.1) {
        direction[2] = -1.0;
    }
    let norm = direction.iter().map(|d| d * d).sum::<f32>().sqrt();
    let direction = direction.map(|d| d / norm);
    let distance = 0.5 + 3.0 * random.unit();
    let origin = [0, 1, 2].map(|axis| {
        let (lo, hi) = (min[axis], max[axis]);
        let anywhere = lo + (hi - lo) * random.unit();
        let targets = [lo, hi, lo.next_down(), hi.next_up(), anywhere];
        targets[(random.unit() * 5.0) as usize] - distance * direction[axis]
    });
    Ray { origin, direction }
}

/// A sample on the surface of the box lies in it, one that is a rounding
/// beyond does not, for the renderer and the oracle alike.
#[test]
fn rays_that_touch_the_box() {
    let mut random = Random(3);
    for occupancy in [None, Some(16), Some(24)] {
        let mut model = Recipe { occupancy, ..Recipe::PLAIN }.build();
        model.sampling.min_transmittance = 0.0;
        let Space::Box { min, max } = model.space else { unreachable!("a new kind of space") };
        let options = options(&model, SimdLevel::detect(), Tuning::SMALL);
        let [mut seen, mut missed] = [0; 2];
        for i in 0..1000 {
            let ray = touching(&mut random, [min, max]);
            let expected = reference::render_ray(&model, &ray).unwrap().samples;
            let found = picture::rays(&model, &[ray], &options).stats.samples;
            assert_eq!(found, u64::from(expected), "{occupancy:?}, ray {i}: {ray:?}");
            seen += u32::from(expected > 0);
            missed += u32::from(expected == 0);
        }
        assert!(seen > 100 && missed > 100, "{seen} seen, {missed} missed");
    }
}
