//! Rays and weights that no camera and no training would give: every call ends,
//! and pictures hold finite numbers.

use pocketnerf_core::field::{AnyField, NerfNetwork, Shading};
use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::reference;
use pocketnerf_core::{DType, Layout, Model, Ray, SamplingMode, TensorView, Tuning};

use crate::models::{Encoding, Random, Recipe, camera, in_contracted, in_ndc};
use crate::picture::{self, Picture, levels, options, whole};

#[track_caller]
fn assert_finite(picture: &Picture, what: &str) {
    for (rgba, depth) in picture.rgba.iter().zip(&picture.depth) {
        assert!(rgba.iter().all(|v| v.is_finite()), "{what}: {rgba:?}");
        assert!(!depth.is_nan(), "{what}: {depth}");
    }
}

#[test]
fn rays_of_every_kind_of_number() {
    const NUMBERS: [f32; 11] = [
        0.0,
        -0.0,
        0.5,
        -1.0,
        f32::MIN_POSITIVE,
        1e-45,
        1e20,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NAN,
    ];
    let mut random = Random(11);
    let mut any = || NUMBERS[(random.unit() * NUMBERS.len() as f32) as usize];
    let rays: Vec<Ray> = (0..3000)
        .map(|_| Ray { origin: [any(), any(), any()], direction: [any(), any(), any()] })
        .collect();
    for recipe in Recipe::nerfs().step_by(3) {
        let model = recipe.build();
        for level in levels() {
            let usual = options(&model, level, Tuning::FAST);
            for reach in [Reach::Distance, Reach::Clipped, Reach::Depth] {
                let hierarchical =
                    SamplingMode::Hierarchical(Hierarchical { n_coarse: 5, n_fine: 6, reach });
                let found = picture::rays(&model, &rays, &usual.with_sampling(hierarchical));
                assert_finite(&found, "strange rays, hierarchical sampling");
            }
            assert_finite(&picture::rays(&model, &rays, &usual), "strange rays");
        }
    }
    let not_a_place = |ray: &Ray| {
        let mut numbers = ray.origin.iter().chain(&ray.direction);
        numbers.any(|v| !v.is_finite())
    };
    for shading in [Shading::PerSample, Shading::PerRay] {
        for occupancy in [None, Some(16)] {
            let model = Recipe { shading, occupancy, ..Recipe::PLAIN }.build();
            for (model, level) in [model, in_ndc(model), in_contracted(model)]
                .iter()
                .flat_map(|m| levels().map(move |l| (m, l)))
            {
                let options = options(model, level, Tuning::FAST);
                let found = picture::rays(model, &rays, &options);
                assert_finite(&found, "strange rays");
                for (ray, rgba) in rays.iter().zip(&found.rgba) {
                    assert!(!not_a_place(ray) || *rgba == [0.0; 4], "{ray:?} sees {rgba:?}");
                }
            }
        }
    }
}

/// The model with value `index` of layer `layer` of a network replaced.
fn poisoned(model: &Model<'static>, of_density: bool, layer: usize, value: f32) -> Model<'static> {
    let mut model = *model;
    let decoder = match &mut model.field {
        AnyField::HashGrid(field) => &mut field.decoder,
        _ => unreachable!("a new kind of field"),
    };
    let network = if of_density { &mut decoder.density } else { &mut decoder.color };
    let mut layers: Vec<Dense<'static>> = network.layers().to_vec();
    let weight = layers[layer].weight;
    let mut bytes = weight.bytes().to_vec();
    bytes[..4].copy_from_slice(&value.to_le_bytes());
    layers[layer].weight =
        TensorView::new(bytes.leak(), DType::F32, weight.shape(), 0, Layout::RowMajor).unwrap();
    *network = Mlp::new(&layers).unwrap();
    model
}

#[test]
fn weights_that_are_no_numbers() {
    let camera = camera(11, 7);
    for encoding in [Encoding::HashGrid(2), Encoding::Corners(4)] {
        for shading in [Shading::PerSample, Shading::PerRay] {
            let sound = Recipe { encoding, shading, ..Recipe::PLAIN }.build();
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN] {
                for (of_density, layer) in [(true, 0), (true, 1), (true, 2), (false, 0), (false, 1)]
                {
                    let model = poisoned(&sound, of_density, layer, value);
                    for level in levels() {
                        let options = options(&model, level, Tuning::SMALL);
                        let found = picture::tile(&model, &camera, whole(&camera), &options);
                        assert_finite(&found, &format!("{value} {of_density} {layer} {level}"));
                    }
                }
            }
        }
    }
}

/// The model with the first weight of a layer of a vanilla NeRF replaced.
fn poisoned_nerf(model: &Model<'static>, of: Layer, value: f32) -> Model<'static> {
    let AnyField::Nerf(mut field) = model.field else { unreachable!("a vanilla NeRF") };
    let poison = |layer: &Dense<'static>| {
        let mut bytes = layer.weight.bytes().to_vec();
        bytes[..4].copy_from_slice(&value.to_le_bytes());
        let (dtype, shape) = (layer.weight.dtype(), layer.weight.shape());
        let weight = TensorView::new(bytes.leak(), dtype, shape, 0, Layout::RowMajor).unwrap();
        Dense { weight, ..*layer }
    };
    let NerfNetwork { skips, linear, mut density, feature, mut color, .. } = field.fine;
    let mut trunk = field.fine.trunk().to_vec();
    match of {
        Layer::Trunk => trunk[0] = poison(&trunk[0]),
        Layer::Density => density = poison(&density),
        Layer::Color => {
            let mut layers = color.layers().to_vec();
            layers[0] = poison(&layers[0]);
            color = Mlp::new(&layers).unwrap();
        }
    }
    field.fine = NerfNetwork::new(&trunk, [skips, linear], density, feature, color).unwrap();
    Model { field: AnyField::Nerf(field), ..*model }
}

#[derive(Clone, Copy, Debug)]
enum Layer {
    Trunk,
    Density,
    Color,
}

#[test]
fn weights_of_vanilla_nerfs_that_are_no_numbers() {
    let camera = camera(11, 7);
    for recipe in Recipe::nerfs().filter(|recipe| recipe.dtype == DType::F32) {
        let sound = recipe.build();
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN] {
            for of in [Layer::Trunk, Layer::Density, Layer::Color] {
                let model = poisoned_nerf(&sound, of, value);
                for level in levels() {
                    let what = format!("{recipe:?} {value} {of:?} {level}");
                    let options = options(&model, level, Tuning::SMALL);
                    let found = picture::tile(&model, &camera, whole(&camera), &options);
                    assert_finite(&found, &what);
                    let h = Hierarchical { n_coarse: 8, n_fine: 8, reach: Reach::Distance };
                    let options = options.with_sampling(SamplingMode::Hierarchical(h));
                    let found = picture::tile(&model, &camera, whole(&camera), &options);
                    assert_finite(&found, &what);
                    if value.is_nan() && matches!(of, Layer::Density) {
                        // A density that is no number is empty space.
                        assert!(found.rgba.iter().all(|rgba| *rgba == [0.0; 4]), "{what}");
                    }
                }
            }
        }
    }
}

/// As the oracle has it: a density that is no number is empty space, and a
/// colour that is none is black.
#[test]
fn nan_is_empty_and_black() {
    let camera = camera(11, 7);
    for shading in [Shading::PerSample, Shading::PerRay] {
        let sound = Recipe { shading, ..Recipe::PLAIN }.build();
        for level in levels() {
            let options = options(&sound, level, Tuning::SMALL);
            let model = poisoned(&sound, true, 2, f32::NAN);
            let empty = picture::tile(&model, &camera, whole(&camera), &options);
            assert!(empty.rgba.iter().all(|rgba| *rgba == [0.0; 4]), "{level}");
            let model = poisoned(&sound, false, 1, f32::NAN);
            let black = picture::tile(&model, &camera, whole(&camera), &options);
            for (i, [red, .., alpha]) in black.rgba.iter().enumerate() {
                let (x, y) = (i as u32 % 11, i as u32 / 11);
                let expected = reference::render_pixel(&model, &camera, x, y).unwrap();
                assert!((alpha - expected.opacity).abs() < 1e-3, "{level}");
                assert_eq!((*red, expected.rgb[0]), (0.0, 0.0), "{level}");
            }
        }
    }
}

/// What is no number in a part of the table is empty there, and no more than that: the
/// rays that pass it see what lies behind.
#[test]
fn nan_entries_hide_nothing() {
    let camera = camera(33, 21);
    for (features, shading) in
        [(2, Shading::PerSample), (4, Shading::PerSample), (4, Shading::PerRay)]
    {
        let encoding = Encoding::HashGrid(features);
        let mut model = Recipe { encoding, shading, ..Recipe::PLAIN }.build();
        let AnyField::HashGrid(field) = &mut model.field else { unreachable!("a hash grid") };
        let table = &mut field.grid.levels[0];
        let mut bytes = table.bytes().to_vec();
        let entry = bytes.len() / table.rows();
        for entry in bytes.chunks_mut(entry).step_by(150) {
            entry.as_chunks_mut::<4>().0.fill(f32::NAN.to_le_bytes());
        }
        let shape = table.shape();
        *table = TensorView::new(bytes.leak(), DType::F32, shape, 0, Layout::RowMajor).unwrap();
        for level in levels() {
            for tuning in [Tuning::SMALL, Tuning::FAST] {
                let found =
                    picture::tile(&model, &camera, whole(&camera), &options(&model, level, tuning));
                let mut bright = 0;
                for (i, rgba) in found.rgba.iter().enumerate() {
                    let (x, y) = (i as u32 % 33, i as u32 / 33);
                    let expected = reference::render_pixel(&model, &camera, x, y).unwrap();
                    for (found, expected) in rgba.iter().zip(expected.rgb) {
                        assert!((found - expected).abs() < 1e-3, "{level}");
                    }
                    bright += usize::from(rgba[3] > 0.05);
                }
                assert!(bright > 10, "{bright} pixels see something");
            }
        }
    }
}

#[test]
fn densities_beyond_measure() {
    let camera = camera(11, 7);
    for shading in [Shading::PerSample, Shading::PerRay] {
        for log_density_bias in [-63.0, 63.0] {
            let mut model = Recipe { shading, ..Recipe::PLAIN }.build();
            if let AnyField::HashGrid(field) = &mut model.field {
                field.decoder.log_density_bias = log_density_bias;
            }
            for step in [1e-4, 0.03, 5.0] {
                model.sampling.step = step;
                for level in levels() {
                    let options = options(&model, level, Tuning::FAST);
                    let found = picture::tile(&model, &camera, whole(&camera), &options);
                    assert_finite(&found, &format!("{log_density_bias} {step} {level}"));
                }
            }
        }
    }
}

#[test]
fn densities_of_vanilla_nerfs_beyond_measure() {
    let camera = camera(11, 7);
    for recipe in Recipe::nerfs() {
        for density_scale in [1e-30, 9e8] {
            let mut model = recipe.build();
            if let AnyField::Nerf(field) = &mut model.field {
                field.density_scale = density_scale;
            }
            for level in levels() {
                let options = options(&model, level, Tuning::FAST);
                for h in [
                    Hierarchical { n_coarse: 9, n_fine: 9, reach: Reach::Clipped },
                    Hierarchical::PAPER,
                ] {
                    let options = options.with_sampling(SamplingMode::Hierarchical(h));
                    let found = picture::tile(&model, &camera, whole(&camera), &options);
                    assert_finite(&found, &format!("{recipe:?} {density_scale} {level}"));
                }
                let found = picture::tile(&model, &camera, whole(&camera), &options);
                assert_finite(&found, &format!("{recipe:?} {density_scale} {level}"));
            }
        }
    }
}
