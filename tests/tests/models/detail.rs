//! Pictures that are not the finest: how far off they are, and that they become
//! the finest.

use std::time::{Duration, Instant};

use pocketnerf_core::render::{Refinement, Refinements, refine_tile};
use pocketnerf_core::{Camera, Error, Model, RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::Progressive;
use pocketnerf_train::picture::{self, Settings};

const BYTES: &[u8] = include_bytes!("../../../embed-demo/still-life.pnerf");

fn views(downscale: u32) -> Dataset {
    let mut held_out = builtin::dataset(Split::Test, downscale);
    held_out.views.truncate(3);
    held_out
}

#[test]
fn quality_is_monotone_and_the_usual_costs_little() {
    let file = pocketnerf_formats::open_verified(BYTES).unwrap();
    let held_out = views(1);
    let score = |quality: f32| {
        let settings = Settings { quality, ..Settings::default() };
        evaluate(&file.model, &held_out, [1.0; 3], &settings, &Metrics::default(), |_, _, _| ())
            .unwrap()
    };
    let finest = score(1.0);
    let mut last = finest.clone();
    for quality in [0.9, 0.7, 0.5, 0.3, 0.1, 0.0] {
        let now = score(quality);
        println!("{quality}: {:.3} dB, {:.3} samples a pixel", now.psnr, now.samples_per_ray);
        // Interpolating may smooth noise away: a trace of gain is no error.
        assert!(now.psnr <= last.psnr + 0.01 && now.samples_per_ray <= last.samples_per_ray);
        assert!(quality < 0.5 || finest.psnr - now.psnr <= 0.05);
        last = now;
    }
    assert!(finest.psnr - last.psnr < 3.0 && last.samples_per_ray < 0.7 * finest.samples_per_ray);
}

/// Two pictures side by side: one by `render_tile`, one in refinements.
struct Both<'m> {
    model: &'m Model<'m>,
    camera: Camera,
    options: RenderOptions,
    tile: Tile,
}

impl Both<'_> {
    fn scratch(&self) -> Vec<f32> {
        vec![f32::NAN; self.options.scratch_len()]
    }

    fn at_once(&self) -> (Vec<f32>, Vec<f32>) {
        let n = self.tile.pixels();
        let (mut rgba, mut depth) = (vec![f32::NAN; n * 4], vec![f32::NAN; n]);
        let to = (&mut rgba, Some(&mut depth[..]));
        render_tile(
            self.model,
            &self.camera,
            self.tile,
            &self.options,
            &mut self.scratch(),
            to.0,
            to.1,
        )
        .unwrap();
        (rgba, depth)
    }

    fn refine(&self, known: u32, spacing: u32, rgba: &mut [f32], depth: &mut [f32]) {
        let piece = Refinement { tile: self.tile, known, spacing };
        let scratch = &mut self.scratch();
        refine_tile(self.model, &self.camera, &piece, &self.options, scratch, rgba, Some(depth))
            .unwrap();
    }
}

#[test]
fn the_last_refinement_is_the_picture() {
    let file = pocketnerf_formats::open_verified(BYTES).unwrap();
    let camera = views(8).views[0].camera;
    let tile = Tile { x: 3, y: 1, width: 37, height: 26 };
    for quality in [1.0, 0.5, 0.2] {
        let options = RenderOptions {
            detail: file.model.detail(quality),
            ..RenderOptions::new(&file.model, SimdLevel::detect(), Tuning::FAST)
        };
        let both = Both { model: &file.model, camera, options, tile };
        let (expected, depths) = both.at_once();
        let n = tile.pixels();
        let (mut rgba, mut depth) = (vec![f32::NAN; n * 4], vec![f32::NAN; n]);
        let mut known = 0;
        let mut errors = Vec::new();
        for spacing in [16, 4, 2, 1] {
            both.refine(known, spacing, &mut rgba, &mut depth);
            known = spacing;
            assert!(rgba.iter().all(|v| (0.0..=1.0001).contains(v)), "after {spacing}");
            assert!(depth.iter().all(|v| *v > 0.0), "depth after {spacing}");
            let error: f32 = rgba.iter().zip(&expected).map(|(a, b)| (a - b).powi(2)).sum();
            errors.push(error);
        }
        assert!(errors.is_sorted_by(|a, b| a > b) && errors[3] == 0.0, "{errors:?}");
        assert_eq!(depth, depths);
    }
}

#[test]
fn work_covers_every_pixel_of_every_level_once() {
    let cases =
        [(40, 24, [16; 2]), (1, 1, [64; 2]), (17, 33, [5, 9]), (0, 7, [8; 2]), (32, 32, [0; 2])];
    for (width, height, side) in cases {
        let mut seen = vec![[0u32; 5]; (width * height) as usize];
        let mut last = u32::MAX;
        for Refinement { tile, known, spacing } in Refinements::new([width, height], side) {
            assert!(spacing <= last && (known == 0 || known == 2 * spacing));
            last = spacing;
            for y in tile.y..tile.y + tile.height {
                for x in tile.x..tile.x + tile.width {
                    seen[(y * width + x) as usize][spacing.ilog2() as usize] += 1;
                }
            }
        }
        assert!(seen.iter().all(|levels| *levels == [1; 5]), "{width}x{height} by {side:?}");
    }
}

#[test]
fn refinements_that_make_no_sense_are_refused() {
    let file = pocketnerf_formats::open_verified(BYTES).unwrap();
    let camera = views(16).views[0].camera;
    let options = RenderOptions::new(&file.model, SimdLevel::detect(), Tuning::SMALL);
    let tile = Tile { x: 0, y: 0, width: 4, height: 4 };
    let mut scratch = vec![0.0; options.scratch_len()];
    for (known, spacing) in [(0, 0), (0, 3), (2, 2), (2, 4), (6, 2), (0, 1 << 20)] {
        let piece = Refinement { tile, known, spacing };
        let mut rgba = [0.5; 64];
        let refused =
            refine_tile(&file.model, &camera, &piece, &options, &mut scratch, &mut rgba, None);
        assert!(matches!(refused, Err(Error::Range(_))), "{known} {spacing}");
        assert_eq!(rgba, [0.5; 64]);
    }
}

#[test]
fn a_deadline_that_has_passed_gives_a_picture_and_rest_finishes_it() {
    let file = pocketnerf_formats::open_verified(BYTES).unwrap();
    let held_out = views(2);
    let camera = &held_out.views[0].camera;
    let settings = Settings { depth: true, ..Settings::default() };
    let whole = picture::render(&file.model, camera, &settings).unwrap();
    let mut progressive = Progressive::new(&file.model, camera, &settings);
    assert!(!progressive.refine(Instant::now()).unwrap());
    assert_eq!(progressive.share(16), 1.0);
    let coarse = progressive.picture();
    let shown = |p: &picture::Picture| p.rgba.iter().filter(|v| **v > 0.0).count();
    assert!(shown(&coarse) * 10 > shown(&whole) * 9, "{} {}", shown(&coarse), shown(&whole));
    assert!(progressive.refine(Instant::now() + Duration::from_secs(600)).unwrap());
    let rested = progressive.picture();
    assert!(rested.rgba == whole.rgba && rested.depth == whole.depth);
    assert_eq!((progressive.share(1), rested.stats.rays), (1.0, whole.stats.rays));
}
