//! Hierarchical sampling: the renderer against the oracle, and invariants of its pictures.

use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::reference::{self, RayResult};
use pocketnerf_core::render::{Refinements, refine_tile};
use pocketnerf_core::{
    Camera, DType, Error, Model, RenderOptions, Sampling, SamplingMode, SimdLevel, Tile, Tuning,
    render_tile,
};

use crate::agreement::compare;
use crate::models::{Encoding, Recipe, camera};
use crate::nerf::Nerf;
use crate::picture::{self, levels, whole};

fn options(model: &Model<'_>, level: SimdLevel, tuning: Tuning, h: Hierarchical) -> RenderOptions {
    RenderOptions::new(model, level, tuning).with_sampling(SamplingMode::Hierarchical(h))
}

fn expected(model: &Model<'_>, camera: &Camera, h: &Hierarchical) -> Vec<RayResult> {
    let (width, n) = (camera.width, camera.width * camera.height);
    let axis = Some(camera.axis());
    let ray = |i: u32| camera.ray((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
    (0..n).map(|i| reference::render_ray_hierarchically(model, &ray(i), axis, h).unwrap()).collect()
}

/// Every third recipe of the other kinds, and all of vanilla NeRF.
fn models() -> impl Iterator<Item = (String, Model<'static>)> {
    let others = Recipe::all().filter(|r| !matches!(r.encoding, Encoding::Nerf(_))).step_by(7);
    others.chain(Recipe::nerfs()).map(|recipe| (format!("{recipe:?}"), recipe.build()))
}

const SAMPLINGS: [Hierarchical; 4] = [
    Hierarchical { n_coarse: 24, n_fine: 40, reach: Reach::Clipped },
    Hierarchical { n_coarse: 19, n_fine: 33, reach: Reach::Distance },
    Hierarchical { n_coarse: 32, n_fine: 0, reach: Reach::Clipped },
    Hierarchical { n_coarse: 32, n_fine: 48, reach: Reach::Depth },
];

#[test]
fn every_kind_of_model_at_every_level() {
    let camera = camera(13, 9);
    let [mut empty, mut seen, mut evaluated] = [0; 3];
    for (what, model) in models() {
        for h in SAMPLINGS {
            let expected = expected(&model, &camera, &h);
            for level in levels() {
                for tuning in [Tuning::SMALL, Tuning::FAST] {
                    let options = options(&model, level, tuning, h);
                    let found = picture::tile(&model, &camera, whole(&camera), &options);
                    compare(&model, &found, &expected, &format!("{what} {h:?} {level} {tuning:?}"));
                }
            }
            empty += expected.iter().filter(|p| p.opacity == 0.0).count();
            seen += expected.iter().filter(|p| p.opacity > 0.5).count();
            evaluated += expected.iter().filter(|p| p.samples > 0).count();
        }
    }
    assert!(empty > 500 && seen > 500 && evaluated > 1000, "{empty} {seen} {evaluated}");
}

/// The original network, eight layers of 256, with both kinds of sampling.
#[test]
fn the_original_network() {
    let camera = camera(4, 3);
    let h = Hierarchical { n_coarse: 8, n_fine: 12, reach: Reach::Distance };
    for dtype in [DType::F32, DType::F16] {
        let nerf = Nerf { coarse: dtype == DType::F16, ..Nerf::PAPER };
        let recipe = Recipe { encoding: Encoding::Nerf(nerf), dtype, ..Recipe::PLAIN };
        let mut model = recipe.build();
        model.sampling.step = 0.2;
        let hierarchical = expected(&model, &camera, &h);
        let mut marched = vec![RayResult::EMPTY; 12];
        reference::render_picture(&model, &camera, &mut marched).unwrap();
        for level in levels() {
            for tuning in [Tuning::SMALL, Tuning::FAST] {
                let options = options(&model, level, tuning, h);
                let found = picture::tile(&model, &camera, whole(&camera), &options);
                compare(&model, &found, &hierarchical, &format!("{dtype:?} {level} {tuning:?}"));
                let finest = picture::options(&model, level, tuning);
                let found = picture::tile(&model, &camera, whole(&camera), &finest);
                compare(&model, &found, &marched, &format!("marched {dtype:?} {level} {tuning:?}"));
            }
        }
    }
}

#[test]
fn every_sample_of_every_ray_is_evaluated() {
    let camera = camera(11, 7);
    let h = Hierarchical { n_coarse: 16, n_fine: 20, reach: Reach::Distance };
    for recipe in Recipe::nerfs() {
        let model = recipe.build();
        for level in levels() {
            let options = options(&model, level, Tuning::FAST, h);
            let stats = picture::tile(&model, &camera, whole(&camera), &options).stats;
            assert_eq!([stats.rays, stats.hits, stats.samples], [77, 77, 77 * (16 + 36)]);
        }
    }
    // Within the space, rays that meet nothing ask for nothing.
    let model = Recipe::PLAIN.build();
    let h = Hierarchical { reach: Reach::Clipped, ..h };
    let options = options(&model, SimdLevel::detect(), Tuning::FAST, h);
    let stats = picture::tile(&model, &camera, whole(&camera), &options).stats;
    let expected = expected(&model, &camera, &h);
    let hits = expected.iter().filter(|ray| ray.samples > 0).count() as u64;
    assert_eq!((stats.rays, stats.hits), (77, hits));
    assert!(stats.hits < 70 && stats.samples < stats.hits * (16 + 36));
}

#[test]
fn tiles_tuning_detail_and_refinements_do_not_show() {
    let camera = camera(40, 24);
    let odd = Tuning { samples: 96, rays: 16 };
    for (_, model) in models().step_by(3) {
        for h in SAMPLINGS {
            let level = levels().last().unwrap();
            let fast = options(&model, level, Tuning::FAST, h);
            let all = picture::tile(&model, &camera, whole(&camera), &fast);
            for (tuning, [width, height], quality) in
                [(Tuning::SMALL, [7, 5], 0.0), (Tuning::FAST, [1, 1], 1.0), (odd, [33, 17], 0.2)]
            {
                let mut options = options(&model, level, tuning, h);
                options.detail = model.detail(quality);
                for (y, x) in (0..24)
                    .step_by(height)
                    .flat_map(|y| (0..40).step_by(width).map(move |x| (y as u32, x as u32)))
                {
                    let (width, height) = (width as u32, height as u32);
                    let tile = Tile { x, y, width: width.min(40 - x), height: height.min(24 - y) };
                    let part = picture::tile(&model, &camera, tile, &options);
                    for (i, pixel) in part.rgba.iter().enumerate() {
                        let i = i as u32;
                        let at = ((y + i / tile.width) * 40 + x + i % tile.width) as usize;
                        assert_eq!(*pixel, all.rgba[at], "{tile:?} pixel {i}");
                        assert_eq!(part.depth[i as usize], all.depth[at], "{tile:?} depth {i}");
                    }
                }
            }
            let (mut rgba, mut scratch) = (vec![0.0; 4 * 40 * 24], vec![0.0; fast.scratch_len()]);
            for step in Refinements::new([40, 24], [40, 24]) {
                refine_tile(&model, &camera, &step, &fast, &mut scratch, &mut rgba, None).unwrap();
            }
            assert_eq!(rgba.as_chunks().0, all.rgba);
        }
    }
}

#[test]
fn colours_stay_below_alpha_and_nothing_is_exactly_nothing() {
    let camera = camera(33, 17);
    for (what, model) in models() {
        for h in SAMPLINGS {
            for level in levels() {
                let options = options(&model, level, Tuning::FAST, h);
                let picture = picture::tile(&model, &camera, whole(&camera), &options);
                for (rgba, depth) in picture.rgba.iter().zip(&picture.depth) {
                    let [rgb @ .., alpha] = *rgba;
                    assert!((0.0..=1.0 + 1e-6).contains(&alpha), "{what}: {rgba:?}");
                    assert!(rgb.iter().all(|c| 0.0 <= *c && *c <= alpha), "{what}: {rgba:?}");
                    if alpha == 0.0 {
                        assert_eq!((rgba, *depth), (&[0.0; 4], f32::INFINITY));
                    } else {
                        let Sampling { near, far, .. } = model.sampling;
                        // Of a corner's ray, the axis is half as long.
                        let far = if h.reach == Reach::Depth { 2.0 * far } else { far };
                        assert!(near * 0.999 <= *depth && *depth <= far * 1.001, "{depth}");
                    }
                }
            }
        }
    }
}

#[test]
fn more_samples_than_the_scratch_was_made_for() {
    let model = Recipe::PLAIN.build();
    let few = Hierarchical { n_coarse: 8, n_fine: 8, reach: Reach::Clipped };
    let mut options = options(&model, SimdLevel::Portable, Tuning::SMALL, few);
    let (mut scratch, mut rgba) = (vec![0.0; options.scratch_len()], [0.0; 4]);
    let tile = Tile { x: 0, y: 0, width: 1, height: 1 };
    let mut render = |options: &RenderOptions| {
        render_tile(&model, &camera(1, 1), tile, options, &mut scratch, &mut rgba, None)
    };
    assert!(render(&options).is_ok());
    options.sampling = SamplingMode::Hierarchical(Hierarchical { n_fine: 9, ..few });
    assert!(matches!(render(&options), Err(Error::Limits(_))));
    for wrong in [Hierarchical { n_coarse: 3, ..few }, Hierarchical { n_fine: 1025, ..few }] {
        let error = render(&options.with_sampling(SamplingMode::Hierarchical(wrong)));
        assert!(matches!(error, Err(Error::Range(_))));
    }
}
