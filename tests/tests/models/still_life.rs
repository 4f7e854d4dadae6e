//! The model that is committed for the embedding demo: made once, and read and
//! rendered for ever.

use pocketnerf_core::reference::render_ray;
use pocketnerf_core::render::Detail;
use pocketnerf_core::{RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::Settings;

const BYTES: &[u8] = include_bytes!("../../../embed-demo/still-life.pnerf");

#[test]
fn shows_the_built_in_scene() {
    assert!(BYTES.len() < 500_000, "{} bytes", BYTES.len());
    let file = pocketnerf_formats::open_verified(BYTES).unwrap();
    let held_out = builtin::dataset(Split::Test, 1);
    let seen = evaluate(
        &file.model,
        &held_out,
        [1.0; 3],
        &Settings::default(),
        &Metrics::default(),
        |_, _, _| (),
    )
    .unwrap();
    println!("{:.2} dB", seen.psnr);
    assert!(seen.psnr > 33.0, "{} dB", seen.psnr);
}

/// A trained model has thin parts, grazing rays and half-transparent edges.
#[test]
fn every_level_and_scratch_agrees_with_the_oracle() {
    const TOLERANCE: f32 = 1e-3;
    let file = pocketnerf_formats::open_verified(BYTES).unwrap();
    let camera = builtin::dataset(Split::Test, 16).views[0].camera;
    let tile = Tile { x: 0, y: 0, width: camera.width, height: camera.height };
    let ray = |i: u32| camera.ray((i % tile.width) as f32 + 0.5, (i / tile.width) as f32 + 0.5);
    let truth: Vec<_> =
        (0..tile.width * tile.height).map(|i| render_ray(&file.model, &ray(i)).unwrap()).collect();
    for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
        for tuning in [Tuning::SMALL, Tuning::FAST] {
            for skip in [false, true] {
                let options = RenderOptions {
                    skip,
                    detail: Detail::FINEST,
                    ..RenderOptions::new(&file.model, simd, tuning)
                };
                let mut scratch = vec![f32::NAN; options.scratch_len()];
                let mut rgba = vec![f32::NAN; truth.len() * 4];
                render_tile(&file.model, &camera, tile, &options, &mut scratch, &mut rgba, None)
                    .unwrap();
                for (pixel, truth) in rgba.as_chunks::<4>().0.iter().zip(&truth) {
                    let expected = [truth.rgb[0], truth.rgb[1], truth.rgb[2], truth.opacity];
                    for (found, expected) in pixel.iter().zip(expected) {
                        assert!((found - expected).abs() <= TOLERANCE, "{simd:?} {pixel:?}");
                    }
                }
            }
        }
    }
}
