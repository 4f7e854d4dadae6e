//! Networks that krrish94/nerf-pytorch trained, in POCKETNERF_DATA.

use pocketnerf_cli::convert::config;
use pocketnerf_core::{Camera, Model, SimdLevel};
use pocketnerf_train::convert::{NerfConversion, Place, Settings};
use pocketnerf_train::dataset::{self, LoadOptions, Split};
use pocketnerf_train::picture::{self, Sampling};
use pocketnerf_train::trainer::ndc_of;

use super::nerf;

/// `lego/checkpoint199999.ckpt` and the like.
fn converted(data: &std::path::Path, name: &str, place: Option<Place>) -> NerfConversion {
    let path = data.join("weights/nerf-pytorch-4x128").join(name);
    let nerf = nerf(&std::fs::read(&path).unwrap()).unwrap();
    let (_, settings) = config::beside(&path).unwrap().unwrap();
    let given = Settings::default().or(settings);
    NerfConversion::new(nerf, given, |_| Ok(place), SimdLevel::detect()).unwrap()
}

/// PSNR of a picture over white or black.
fn psnr(model: &Model<'_>, camera: &Camera, truth: &[f32], sampling: Sampling) -> (f64, f64) {
    let settings = picture::Settings { sampling, quality: 1.0, ..picture::Settings::default() };
    let picture = picture::render(model, camera, &settings).unwrap();
    let rgb = picture.over(model.display.background);
    let squares: f64 = rgb.iter().zip(truth).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let evaluations = picture.stats.samples as f64 / (rgb.len() / 3) as f64;
    (10.0 * (rgb.len() as f64 / squares).log10(), evaluations)
}

/// Every fifth pixel along both axes of two test views at 400x400: an independent
/// evaluation in f64, in torch, gives 27.494 and 27.898 dB.
#[test]
fn lego_as_its_program_shows_it() {
    let Some(data) = pocketnerf_tests::data() else { return };
    let conversion = converted(&data, "lego/checkpoint199999.ckpt", None);
    let model = conversion.model().unwrap();
    let options = LoadOptions { downscale_factor: 2, ..LoadOptions::default() };
    let lego = dataset::load_with(&data.join("nerf_synthetic/lego"), Split::Test, &options);
    for view in lego.unwrap().views {
        let expected = match &view.name {
            name if name.ends_with("/r_0.png") => 27.494,
            name if name.ends_with("/r_56.png") => 27.898,
            _ => continue,
        };
        // Pixel i's ray goes through the corner of pixel 5 i.
        let mut camera = view.camera;
        [camera.width, camera.height] = [80, 80];
        camera.focal = camera.focal.map(|f| f / 5.0);
        camera.center = camera.center.map(|c| c / 5.0 + 0.5);
        let truth: Vec<f32> = (0..80 * 80)
            .flat_map(|i| {
                let at = 4 * (5 * (i / 80) * 400 + 5 * (i % 80));
                let [r, g, b, a] = [0, 1, 2, 3].map(|c| f32::from(view.rgba[at + c]) / 255.0);
                [r, g, b].map(|c| c * a + 1.0 - a)
            })
            .collect();
        let (found, _) = psnr(&model, &camera, &truth, Sampling::Hierarchical);
        assert!((found - expected).abs() < 0.02, "{}: {found}", view.name);
        // Cells leave out what floats beside the object.
        let (baked, evaluations) = psnr(&model, &camera, &truth, Sampling::Occupancy);
        assert!(baked > expected - 0.1, "{}: {baked}", view.name);
        assert!(evaluations * 15.0 < 192.0, "{evaluations}");
        println!("{}: {found:.3} dB; in cells {baked:.3} dB, {evaluations:.2}", view.name);
    }
}

/// Normalised device coordinates, and a background at infinity.
#[test]
fn fern_in_its_own_coordinates() {
    let Some(data) = pocketnerf_tests::data() else { return };
    let fern = dataset::load(&data.join("llff/fern"), Split::Test, 3).unwrap();
    let ndc = ndc_of(&fern.views, 1.0).unwrap();
    let conversion = converted(&data, "fern/checkpoint249999.ckpt", Some(Place::Ndc(ndc)));
    let model = conversion.model().unwrap();
    let view = &fern.views[0];
    let truth: Vec<f32> = view
        .rgba
        .as_chunks()
        .0
        .iter()
        .flat_map(|[r, g, b, _]| [r, g, b])
        .map(|c| f32::from(*c) / 255.0)
        .collect();
    for sampling in [Sampling::Hierarchical, Sampling::Occupancy] {
        let mut camera = view.camera;
        // The program's rays: corners of pixels three times smaller.
        camera.center = camera.center.map(|c| c + 0.5 / 3.0);
        let (found, evaluations) = psnr(&model, &camera, &truth, sampling);
        println!("fern: {found:.2} dB, {evaluations:.1} evaluations");
        assert!(found > 23.0, "{found}");
    }
}
