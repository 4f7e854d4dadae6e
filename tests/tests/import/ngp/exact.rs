//! Along 1,000 rays, what the programs would show: evaluated in f64 in Python.

use pocketnerf_cli::convert::nerfstudio;
use pocketnerf_core::render::{Detail, RenderOptions, render_rays};
use pocketnerf_core::{Model, Ray, SimdLevel, Tuning};
use pocketnerf_formats::import::ngp::Ngp;
use pocketnerf_formats::{About, Precision, Scene};
use pocketnerf_train::convert::{NgpConversion, Settings};

use super::{bytes, ngp, path};

/// Most that a value between 0 and 1 may differ in f32.
const TOLERANCE: f32 = 1e-4;

/// Origins and directions in the dataset's coordinates, and what is seen.
fn expected(name: &str) -> Vec<[f32; 10]> {
    let bytes = bytes(&format!("{name}.rays.bin"));
    let numbers: Vec<f32> =
        bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let rays = numbers.as_chunks::<10>().0;
    assert_eq!(rays.len(), 1000);
    rays.to_vec()
}

/// The ray in the model's coordinates, rounded once.
fn to_model(scene: &Scene<'_>, ray: &[f32; 10]) -> Ray {
    let turned = |v: [f64; 3]| {
        let along = |i: usize, j: usize| f64::from(scene.rotation[j][i]) * v[j];
        [0, 1, 2].map(|i| (along(i, 0) + along(i, 1) + along(i, 2)) as f32)
    };
    let moved = |a: usize| f64::from(ray[a]) - f64::from(scene.translation[a]);
    Ray {
        origin: turned([0, 1, 2].map(|a| moved(a) / f64::from(scene.scale))),
        direction: turned([3, 4, 5].map(|a| f64::from(ray[a]))),
    }
}

fn show(model: &Model<'_>, scene: &Scene<'_>, rays: &[[f32; 10]], simd: SimdLevel) -> Vec<f32> {
    let rays: Vec<Ray> = rays.iter().map(|ray| to_model(scene, ray)).collect();
    let mut options = RenderOptions::new(model, simd, Tuning::FAST);
    options.detail = Detail::FINEST;
    let (mut rgba, mut scratch) = (vec![0.0; 4 * rays.len()], vec![0.0; options.scratch_len()]);
    render_rays(model, &rays, &options, &mut scratch, &mut rgba, None).unwrap();
    rgba
}

#[track_caller]
pub(crate) fn agree(source: Ngp, program: &str, name: &str) {
    assert!(source.program().contains(program), "{}", source.program());
    let settings = Settings { background: Some([0.0; 3]), ..Settings::default() };
    let conversion = NgpConversion::new(source, settings, None, SimdLevel::detect()).unwrap();
    let (model, scene) = (conversion.model().unwrap(), conversion.scene());
    let rays = expected(name);
    for simd in [SimdLevel::Portable, SimdLevel::detect()] {
        let found = show(&model, &scene, &rays, simd);
        let (mut most, mut seen) = (0.0f32, 0);
        for (found, expected) in found.as_chunks::<4>().0.iter().zip(&rays) {
            let apart = found.iter().zip(&expected[6..]).map(|(a, b)| (a - b).abs());
            most = apart.fold(most, f32::max);
            seen += usize::from(expected[9] > 0.01);
        }
        println!("{name} {simd}: {most:.2e} at most, {seen} rays see something");
        assert!(most < TOLERANCE && seen > 500, "{name} {simd}: {most}, {seen} rays");
    }
    // Through a file: f32 to the same bits; in f16, PSNR against the source.
    let about = About { scene, ..About::default() };
    for (precision, psnr) in [(Precision::F32, f32::INFINITY), (Precision::F16, 55.0)] {
        let bytes = pocketnerf_formats::write(&model, &about, precision).unwrap();
        let file = pocketnerf_formats::open_verified(&bytes).unwrap();
        assert_eq!(file.about.scene, scene);
        let simd = SimdLevel::detect();
        let [source, found] = [&model, &file.model].map(|model| show(model, &scene, &rays, simd));
        let squares: f32 = source.iter().zip(&found).map(|(a, b)| (a - b).powi(2)).sum();
        let found = 10.0 * (source.len() as f32 / squares).log10();
        println!("{name} {precision:?}: {found:.1} dB");
        assert!(found >= psnr, "{name} {precision:?}: {found} dB");
    }
}

#[test]
fn instant_ngp() {
    for (file, rays) in [
        ("fused.msgpack", "fused"),
        ("cutlass.ingp", "cutlass"),
        ("cutlass_gzip.ingp", "cutlass"),
        ("old.msgpack", "old"),
    ] {
        agree(ngp(&bytes(file)).unwrap(), "instant-ngp", rays);
    }
}

#[test]
fn torch_ngp() {
    for name in ["torch/torch_ngp", "torch/torch_ngp_old"] {
        agree(ngp(&bytes(&format!("{name}.pth"))).unwrap(), "torch-ngp", name);
    }
}

#[test]
fn nerfstudio_both_ways() {
    for name in ["torch/nerfstudio_tcnn", "torch/nerfstudio_torch"] {
        let file = format!("{name}/nerfstudio_models/step-000000009.ckpt");
        let mut ngp = ngp(&bytes(&file)).unwrap();
        let settings = nerfstudio::complete(&mut ngp, &path(&file)).unwrap();
        assert_eq!((settings.background, settings.near), (Some([0.0; 3]), Some(0.01)));
        agree(ngp, "nerfstudio", name);
    }
}

#[test]
fn ngp_pl() {
    agree(ngp(&bytes("torch/ngp_pl.ckpt")).unwrap(), "ngp_pl", "torch/ngp_pl");
}
