//! What holds of every picture, to the bit.

use pocketnerf_core::{Model, Ray, RenderOptions, Sampling, Space, Tile, Tuning};

use crate::models::{Random, Recipe, camera, in_contracted, in_ndc, occupancy};
use crate::picture::{self, levels, options, whole};

/// Most that a sum of weights may exceed 1: the rounding of its additions.
const OPACITY_ROUNDING: f32 = 1e-6;

/// Some of the models, one of each encoding, stored type and shading at least; some in
/// normalised device coordinates and in contracted space.
fn some() -> impl Iterator<Item = Model<'static>> {
    let forwards = Recipe::all().skip(1).step_by(5).map(|recipe| in_ndc(recipe.build()));
    let around = Recipe::all().skip(2).step_by(5).map(|recipe| in_contracted(recipe.build()));
    Recipe::all().step_by(3).map(Recipe::build).chain(forwards).chain(around)
}

#[test]
fn tiles_and_tuning_do_not_show() {
    let camera = camera(40, 24);
    let odd = Tuning { samples: 96, rays: 16 };
    for model in some() {
        for level in levels() {
            let fast = options(&model, level, Tuning::FAST);
            let all = picture::tile(&model, &camera, whole(&camera), &fast);
            for (tuning, [width, height]) in
                [(Tuning::SMALL, [7, 5]), (Tuning::FAST, [1, 1]), (odd, [33, 17])]
            {
                let options = options(&model, level, tuning);
                for y in (0..24).step_by(height as usize) {
                    for x in (0..40).step_by(width as usize) {
                        let (width, height) = (width.min(40 - x), height.min(24 - y));
                        let tile = Tile { x, y, width, height };
                        let part = picture::tile(&model, &camera, tile, &options);
                        for (i, pixel) in part.rgba.iter().enumerate() {
                            let (column, row) = (x + i as u32 % width, y + i as u32 / width);
                            let at = (row * 40 + column) as usize;
                            assert_eq!(*pixel, all.rgba[at], "{level} {tile:?} pixel {i}");
                            assert_eq!(part.depth[i], all.depth[at], "{level} {tile:?} depth {i}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn rays_are_pixels() {
    let camera = camera(9, 7);
    let rays: Vec<Ray> =
        (0..63).map(|i| camera.ray((i % 9) as f32 + 0.5, (i / 9) as f32 + 0.5)).collect();
    for model in some() {
        for level in levels() {
            let options = options(&model, level, Tuning::SMALL);
            let tile = picture::tile(&model, &camera, whole(&camera), &options);
            picture::rays(&model, &rays, &options).assert_same(&tile, "rays");
        }
    }
}

#[test]
fn colours_stay_below_alpha_and_nothing_is_exactly_nothing() {
    let camera = camera(33, 17);
    for model in some() {
        let background = model.display.background;
        for level in levels() {
            let options = options(&model, level, Tuning::FAST);
            let picture = picture::tile(&model, &camera, whole(&camera), &options);
            for (rgba, depth) in picture.rgba.iter().zip(&picture.depth) {
                let [rgb @ .., alpha] = *rgba;
                assert!((0.0..=1.0 + OPACITY_ROUNDING).contains(&alpha), "{rgba:?}");
                for (color, background) in rgb.iter().zip(background) {
                    assert!(0.0 <= *color && *color <= alpha, "{rgba:?}");
                    if alpha == 0.0 {
                        assert_eq!(color + (1.0 - alpha) * background, background);
                    }
                }
                if alpha == 0.0 {
                    assert_eq!((rgba, *depth), (&[0.0; 4], f32::INFINITY));
                } else {
                    let Sampling { near, far, .. } = model.sampling;
                    // From (.., .., 2.2) to the near plane, and on to z' = 0.9, z = -20.
                    let [near, far] = match model.space {
                        Space::Box { .. } => [near, far],
                        Space::Ndc(_) => [3.2, 22.2 * 3.0],
                        // From 0.1 radii to 1 / MARGIN of them.
                        _ => [0.1 * 1.4, 1.4e5 * 2.0],
                    };
                    assert!(near < *depth && *depth < far, "{depth}");
                }
            }
        }
    }
}

#[test]
fn scratch_may_hold_anything_and_depth_may_be_left_out() {
    let camera = camera(13, 9);
    for model in some() {
        for level in levels() {
            for tuning in [Tuning::SMALL, Tuning::FAST] {
                let options = options(&model, level, tuning);
                let picture = picture::tile(&model, &camera, whole(&camera), &options);
                for garbage in [0.0, 1e30, f32::NEG_INFINITY] {
                    let mut scratch = vec![garbage; options.scratch_len() + 3];
                    let mut rgba = vec![[garbage; 4]; 13 * 9 + 2];
                    let (tile, flat) = (whole(&camera), rgba.as_flattened_mut());
                    let stats = pocketnerf_core::render_tile(
                        &model,
                        &camera,
                        tile,
                        &options,
                        &mut scratch,
                        flat,
                        None,
                    );
                    assert_eq!(stats, Ok(picture.stats));
                    assert_eq!(rgba[..13 * 9], picture.rgba, "scratch of {garbage}");
                    assert_eq!(rgba[13 * 9..], [[garbage; 4]; 2], "beyond the tile");
                }
            }
        }
    }
}

/// Larger scratch than the model needs, as for a program that opens many.
#[test]
fn generous_limits_do_not_show() {
    let camera = camera(13, 9);
    for model in some() {
        for level in levels() {
            let exact = options(&model, level, Tuning::SMALL);
            let mut generous = exact;
            generous.limits.width += 40;
            generous.limits.rows = generous.limits.rows.map(|rows| rows + 40);
            generous.limits.channels += 5;
            picture::tile(&model, &camera, whole(&camera), &generous).assert_same(
                &picture::tile(&model, &camera, whole(&camera), &exact),
                "generous limits",
            );
        }
    }
}

/// Strides across empty cells lose no sample, even where samples lie on the
/// walls between cells and rays run along them.
#[test]
fn skipping_does_not_show() {
    let level = levels().last().unwrap();
    let mut random = Random(7);
    for resolution in [8, 16, 24, 40, 56, 64] {
        let mut model = Recipe::PLAIN.build();
        model.occupancy = Some(occupancy(resolution, &mut random));
        model.space = Space::Box { min: [0.0; 3], max: [1.0; 3] };
        let cell = 1.0 / resolution as f32;
        for step in [cell, 0.5 * cell, 0.031, 0.003] {
            // Samples at whole steps.
            let near = 0.5 * step;
            model.sampling = Sampling { step, near, far: 8.0, min_transmittance: 0.0 };
            let mut rays = Vec::new();
            for _ in 0..200 {
                let wall = |random: &mut Random| (random.unit() * resolution as f32).floor() * cell;
                let inside = [wall(&mut random), wall(&mut random), wall(&mut random)];
                let turn = |random: &mut Random| random.signed().round();
                let straight = [turn(&mut random), turn(&mut random), turn(&mut random)];
                let any = [random.signed(), random.signed(), random.signed()];
                let nearly = [0, 1, 2].map(|axis| straight[axis] + 1e-4 * any[axis] * any[axis]);
                for direction in [straight, nearly, any] {
                    for far in [0.0, 2.0, 7.0] {
                        let origin = [0, 1, 2].map(|axis| inside[axis] - far * direction[axis]);
                        rays.push(Ray { origin, direction });
                    }
                }
            }
            let skipping = options(&model, level, Tuning::FAST);
            let stepping = RenderOptions { skip: false, ..skipping };
            picture::rays(&model, &rays, &skipping).assert_same(
                &picture::rays(&model, &rays, &stepping),
                &format!("{resolution} cells, step {step}"),
            );
        }
    }
}

/// Large tiles: cells are cast onto the picture before any ray.
#[test]
fn what_is_cast_beforehand_does_not_show() {
    let level = levels().last().unwrap();
    let mut saved = 0;
    for model in some() {
        for (camera, far) in [(camera(64, 48), 1.0), (camera(97, 33), 0.3), (camera(50, 70), 20.0)]
        {
            let mut camera = camera;
            for row in camera.camera_to_world.chunks_mut(4).take(3) {
                row[3] *= far;
            }
            let skipping = options(&model, level, Tuning::FAST);
            let stepping = RenderOptions { skip: false, ..skipping };
            let skipping = picture::tile(&model, &camera, whole(&camera), &skipping);
            let mut stepping = picture::tile(&model, &camera, whole(&camera), &stepping);
            saved += stepping.stats.rays - skipping.stats.rays;
            // Rays that are not cast leave others room in a batch.
            stepping.stats = skipping.stats;
            skipping.assert_same(&stepping, &format!("{far} times as far"));
        }
    }
    assert!(saved > 10_000, "{saved}");
}
