//! Requests that cannot be met are refused by a typed error, and nothing is
//! written.

use pocketnerf_core::{
    Error, Limits, Model, RenderOptions, Sampling, SimdLevel, Space, Tuning, render_tile,
};

use crate::models::{Recipe, camera};
use crate::picture::{levels, options, whole};

/// Renders 5 × 3 pixels into buffers of the given lengths; asserts that nothing
/// was written, and gives the error.
#[track_caller]
fn refused(
    model: &Model<'_>,
    options: &RenderOptions,
    scratch: usize,
    rgba: usize,
    depth: usize,
) -> Error {
    const UNTOUCHED: f32 = -7.0;
    let camera = camera(5, 3);
    let mut scratch = vec![0.0; scratch];
    let (mut rgba, mut depth) = (vec![UNTOUCHED; rgba], vec![UNTOUCHED; depth]);
    let result = render_tile(
        model,
        &camera,
        whole(&camera),
        options,
        &mut scratch,
        &mut rgba,
        Some(&mut depth),
    );
    assert!(rgba.iter().chain(&depth).all(|v| *v == UNTOUCHED), "{result:?}");
    result.unwrap_err()
}

#[test]
fn short_buffers() {
    let model = Recipe::PLAIN.build();
    for level in levels() {
        let options = options(&model, level, Tuning::SMALL);
        let needed = options.scratch_len();
        assert_eq!(
            refused(&model, &options, needed - 1, 60, 15),
            Error::ScratchTooSmall { needed, given: needed - 1 }
        );
        assert_eq!(
            refused(&model, &options, needed, 59, 15),
            Error::OutputLength { needed: 60, given: 59 }
        );
        assert_eq!(
            refused(&model, &options, needed, 60, 14),
            Error::OutputLength { needed: 15, given: 14 }
        );
    }
}

#[test]
fn limits_that_the_model_exceeds() {
    let model = Recipe::PLAIN.build();
    let fits = options(&model, SimdLevel::Portable, Tuning::SMALL);
    let Limits { width, rows: [a, b], channels, .. } = fits.limits;
    for limits in [
        Limits { width: width - 1, ..fits.limits },
        Limits { rows: [a - 1, b], ..fits.limits },
        Limits { rows: [a, b - 1], ..fits.limits },
        Limits { channels: channels - 1, ..fits.limits },
    ] {
        let options = RenderOptions { limits, ..fits };
        let error = refused(&model, &options, fits.scratch_len(), 60, 15);
        assert!(matches!(error, Error::Limits(_)), "{error}");
    }
}

#[test]
fn tuning_that_kernels_cannot_work_with() {
    let model = Recipe::PLAIN.build();
    for (samples, rays) in [(0, 0), (16, 16), (33, 16), (32, 0), (32, 5), (32, 48)] {
        let options = options(&model, SimdLevel::Portable, Tuning { samples, rays });
        let error = refused(&model, &options, 100_000, 60, 15);
        assert!(matches!(error, Error::Range(_)), "{samples} {rays}: {error}");
    }
}

/// A small file may ask for hours of work.
#[test]
fn more_samples_than_are_allowed() {
    let model = Recipe::PLAIN.build();
    let camera = camera(5, 3);
    for level in levels() {
        let free = options(&model, level, Tuning::SMALL);
        let render = |options: &RenderOptions| {
            let (mut scratch, mut rgba) = (vec![0.0; options.scratch_len()], vec![0.0; 60]);
            let tile = whole(&camera);
            let stats = render_tile(&model, &camera, tile, options, &mut scratch, &mut rgba, None)?;
            Ok((stats, rgba))
        };
        let allowing = |n: u32| RenderOptions { max_samples_per_pixel: n, ..free };
        let whole: Result<_, Error> = render(&free);
        let samples = whole.clone().unwrap().0.samples;
        assert!(samples > 15, "{samples}");
        let enough = u32::try_from(samples.div_ceil(15)).unwrap();
        assert_eq!(render(&allowing(enough)), whole);
        // 15 pixels; whole batches are evaluated before it is noticed.
        assert_eq!(render(&allowing(1)), Err(Error::TooManySamples { allowed: 15 }));
        assert_eq!(render(&allowing(0)), Err(Error::TooManySamples { allowed: 0 }));
    }
}

#[test]
fn levels_that_the_machine_lacks() {
    let model = Recipe::PLAIN.build();
    let mut missing = 0;
    for level in SimdLevel::ALL.into_iter().filter(|level| !level.is_available()) {
        let options = options(&model, level, Tuning::SMALL);
        let error = refused(&model, &options, options.scratch_len(), 60, 15);
        assert_eq!(error, Error::SimdUnavailable(level));
        missing += 1;
    }
    assert!(missing > 0, "no machine has both Neon and AVX2");
}

/// A model put together by hand need not have been validated.
#[test]
fn models_whose_parts_do_not_fit() {
    let model = Recipe::PLAIN.build();
    let options = options(&model, SimdLevel::Portable, Tuning::SMALL);
    let sampling = |change: fn(&mut Sampling)| {
        let mut model = model;
        change(&mut model.sampling);
        model
    };
    for wrong in [
        sampling(|s| s.step = 0.0),
        sampling(|s| s.step = -1.0),
        sampling(|s| s.step = 1e-9),
        sampling(|s| s.far = f32::INFINITY),
        Model { space: Space::Box { min: [0.0; 3], max: [0.0; 3] }, ..model },
        Model { space: Space::Box { min: [0.0; 3], max: [f32::NAN; 3] }, ..model },
    ] {
        let error = refused(&wrong, &options, options.scratch_len(), 60, 15);
        assert!(matches!(error, Error::Range(_)), "{error}");
    }
}
