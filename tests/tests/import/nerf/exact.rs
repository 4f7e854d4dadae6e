//! Along 1,000 rays, what the programs themselves would show: evaluated in f64 by
//! `tests/fixtures/nerf_networks.py`.

use pocketnerf_core::encoding::Affine;
use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::render::render_rays;
use pocketnerf_core::{
    AnyField, ColorSpace, Display, Model, Ray, RenderOptions, Sampling, SamplingMode, SimdLevel,
    Space, Tuning,
};
use pocketnerf_formats::import::nerf::Nerf;
use pocketnerf_formats::{About, Precision};

use super::{bytes, nerf, pair};

/// Most that a value between 0 and 1 may differ in f32.
const TOLERANCE: f32 = 1e-4;
/// Coordinates that do not look like the scene's: the map has something to do.
const SPACE: Space = Space::Box { min: [-2.0, -1.0, -1.5], max: [1.0, 3.0, 2.0] };

fn numbers(name: &str) -> Vec<f32> {
    bytes(name).as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

fn model(nerf: &Nerf, [n_coarse, n_fine]: [u32; 2]) -> Model<'_> {
    let map = SPACE.unit_map();
    let map = Affine { scale: [1.0 / map.scale; 3], offset: map.min };
    Model {
        field: AnyField::Nerf(nerf.field(map).unwrap()),
        space: SPACE,
        occupancy: None,
        sampling: Sampling { step: 0.01, near: 2.0, far: 6.0, min_transmittance: 0.0 },
        hierarchical: Some(Hierarchical { n_coarse, n_fine, reach: Reach::Distance }),
        display: Display {
            background: [0.0; 3],
            color_space: ColorSpace::Srgb,
            tolerance: Display::TOLERANCE,
        },
    }
}

/// The same with the coarse network, where there is one, in place of the fine one.
fn of_the_coarse<'m>(model: &Model<'m>) -> Model<'m> {
    let mut model = *model;
    if let AnyField::Nerf(field) = &mut model.field {
        field.fine = field.coarse.unwrap_or(field.fine);
    }
    model
}

fn show(model: &Model<'_>, simd: SimdLevel) -> Vec<f32> {
    let rays: Vec<Ray> = numbers("rays.bin")
        .as_chunks::<6>()
        .0
        .iter()
        .map(|[a, b, c, d, e, f]| Ray { origin: [*a, *b, *c], direction: [*d, *e, *f] })
        .collect();
    let sampling = SamplingMode::Hierarchical(model.hierarchical.unwrap());
    let options = RenderOptions::new(model, simd, Tuning::FAST).with_sampling(sampling);
    let (mut rgba, mut scratch) = (vec![0.0; 4 * rays.len()], vec![0.0; options.scratch_len()]);
    render_rays(model, &rays, &options, &mut scratch, &mut rgba, None).unwrap();
    rgba
}

/// The largest difference of each ray's values, in ascending order.
fn apart(found: &[f32], expected: &[[f32; 4]]) -> Vec<f32> {
    assert_eq!(found.len(), 4 * expected.len());
    let rays = found.as_chunks::<4>().0.iter().zip(expected);
    let of = |(a, b): (&[f32; 4], &[f32; 4])| {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let mut apart: Vec<f32> = rays.map(of).collect();
    apart.sort_unstable_by(f32::total_cmp);
    apart
}

#[track_caller]
fn agree(nerf: &Nerf, program: &str, expected: &str) {
    assert!(nerf.program().contains(program), "{}", nerf.program());
    let expected = numbers(&format!("{expected}.bin"));
    let [even, drawn, coarse] = expected.as_chunks::<4>().0.as_chunks::<1000>().0 else {
        panic!("{} numbers", expected.len());
    };
    let [by_even, by_both] = [model(nerf, [32, 0]), model(nerf, [12, 16])];
    for simd in [SimdLevel::Portable, SimdLevel::detect()] {
        // Both networks, evaluated at points that no rounding moves.
        for (model, expected) in [(&by_even, even), (&of_the_coarse(&by_even), coarse)] {
            let most = apart(&show(model, simd), expected)[999];
            assert!(most < TOLERANCE, "{program} {simd}: {most}");
        }
        // Torch itself, in f32, is up to 3e-4 off, on three rays.
        let apart = apart(&show(&by_both, simd), drawn);
        assert!(
            apart[990] < TOLERANCE && apart[999] < 1e-3,
            "{program} {simd}: {:?}",
            &apart[990..]
        );
    }
    let model = by_both;
    // Through a file: f32 to the same bits; in f16, PSNR against the source.
    for (precision, psnr) in [(Precision::F32, f32::INFINITY), (Precision::F16, 55.0)] {
        let bytes = pocketnerf_formats::write(&model, &About::default(), precision).unwrap();
        let file = pocketnerf_formats::open_verified(&bytes).unwrap();
        let [source, found] = [&model, &file.model].map(|model| show(model, SimdLevel::detect()));
        let squares: f32 = source.iter().zip(&found).map(|(a, b)| (a - b).powi(2)).sum();
        let found = 10.0 * (source.len() as f32 / squares).log10();
        assert!(found >= psnr, "{program} {precision:?}: {found} dB");
    }
}

#[test]
fn yenchenlin_in_a_zip_archive() {
    agree(&nerf(&bytes("yenchenlin.tar")).unwrap(), "yenchenlin", "yenchenlin");
}

#[test]
fn bmild_in_two_files_of_numpy() {
    agree(&pair(), "bmild", "yenchenlin");
}

#[test]
fn without_directions_in_safetensors() {
    let nerf = nerf(&bytes("without_directions.safetensors")).unwrap();
    assert!(!nerf.has_coarse());
    agree(&nerf, "yenchenlin", "without_directions");
}

#[test]
fn krrish94_in_pickles_and_archives() {
    for (name, model) in [
        ("flexible", "FlexibleNeRFModel"),
        ("first_paper", "PaperNeRFModel"),
        ("replicate", "ReplicateNeRFModel"),
    ] {
        agree(&nerf(&bytes(&format!("{name}.ckpt"))).unwrap(), model, name);
    }
}

#[test]
fn nerf_pl_of_lightning() {
    agree(&nerf(&bytes("nerf_pl.ckpt")).unwrap(), "nerf_pl", "nerf_pl");
}
