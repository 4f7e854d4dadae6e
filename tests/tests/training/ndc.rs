//! A forward-facing capture, learnt in normalised device coordinates.

use std::time::Instant;

use pocketnerf_core::{Camera, Ray, SimdLevel, Space};
use pocketnerf_formats::{About, Precision};
use pocketnerf_train::dataset::{Dataset, Split, View};
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::{self, Settings};
use pocketnerf_train::trainer::{FinishingBudget, Length, Run, TrainConfig, Trainer, ndc_of};

use super::setup;

/// A wave on a plane at z = -10, half of it behind another at z = -2: colour, and the
/// distance along the ray.
fn truth(ray: &Ray) -> ([f32; 3], f32) {
    let meet = |z: f32| {
        let t = (z - ray.origin[2]) / ray.direction[2];
        ([0, 1].map(|a| ray.origin[a] + t * ray.direction[a]), t)
    };
    let wave = |[x, y]: [f32; 2], length: f32| {
        let [x, y] = [x, y].map(|v| 0.5 + 0.4 * (v * std::f32::consts::TAU / length).sin());
        [x, y, 0.5 * (x + y)]
    };
    let (near, t) = meet(-2.0);
    if near[0] < 0.1 {
        return (wave(near, 0.5).map(|c| 1.0 - c), t);
    }
    let (far, t) = meet(-10.0);
    (wave(far, 2.0), t)
}

/// Five by five cameras, or the places between them, that look along -z.
pub(crate) fn capture(split: Split) -> Dataset {
    let (n, first) = if split == Split::Train { (5, -0.3) } else { (2, -0.075) };
    let place = |i: u32| first + 0.15 * i as f32;
    let views = (0..n * n).map(|i| {
        let position = [place(i % n), place(i / n), 0.0];
        let ahead = [position[0], position[1], -1.0];
        let pose = Camera::look_at(position, ahead, [0.0, 1.0, 0.0]);
        let camera = Camera::from_fov_x(48, 40, 1.0, pose);
        let pixels =
            (0..48 * 40).map(|i| truth(&camera.ray((i % 48) as f32 + 0.5, (i / 48) as f32 + 0.5)));
        let (colors, depths): (Vec<_>, Vec<_>) = pixels.unzip();
        let rgba = colors.iter().flat_map(|c| {
            let [r, g, b] = c.map(|c| (c * 255.0).round() as u8);
            [r, g, b, 255]
        });
        View { depth: Some(depths), ..View::new(format!("{i}"), camera, rgba.collect()) }
    });
    Dataset::new("two planes", "computed", split, views.collect())
}

pub(crate) fn config(dataset: &Dataset) -> TrainConfig {
    let ndc = ndc_of(&dataset.views, 1.0).unwrap();
    TrainConfig { aabb: None, ndc: Some(ndc), ..setup::config() }
}

#[test]
fn views_between_are_learnt() {
    let (dataset, held_out) = (capture(Split::Train), capture(Split::Test));
    let config = TrainConfig { samples_per_side: 128.0, ..config(&dataset) };
    let mut trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
    let mut run = Run::new(Length::Steps(1000), Instant::now());
    while run.step(&mut trainer).unwrap().is_some() {}
    let finished =
        trainer.finished(FinishingBudget::usual(trainer.config(), trainer.steps())).unwrap();
    let bytes =
        pocketnerf_formats::write(&finished.model(), &About::default(), Precision::I8).unwrap();
    let file = pocketnerf_formats::open_verified(&bytes).unwrap();
    assert!(matches!(file.model.space, Space::Ndc(ndc) if ndc.near == 1.0));
    let background = file.model.display.background;
    let found = evaluate(
        &file.model,
        &held_out,
        background,
        &Settings::default(),
        &Metrics::default(),
        |_, _, _| (),
    );
    let psnr = found.unwrap().psnr;
    println!("{psnr} dB");
    assert!(psnr > 25.0, "{psnr} dB");
    // Depths are Euclidean, and those of the planes.
    let settings = Settings { depth: true, ..Settings::default() };
    let (mut right, mut all) = (0, 0);
    for view in &held_out.views {
        let picture = picture::render(&file.model, &view.camera, &settings).unwrap();
        for (truth, found) in view.depth.as_ref().unwrap().iter().zip(&picture.depth) {
            all += 1;
            right += u32::from((truth / found - 1.0).abs() < 0.2);
        }
    }
    println!("{right} of {all}");
    assert!(right * 4 > all * 3, "{right} of {all}");
}

#[test]
fn an_interruption_leaves_no_trace() {
    let dataset = capture(Split::Train);
    let new =
        || Trainer::with_prepass(dataset.clone(), config(&dataset), SimdLevel::detect()).unwrap();
    let end = |mut trainer: Trainer, mut run: Run| {
        while run.step(&mut trainer).unwrap().is_some() {}
        let finished =
            trainer.finished(FinishingBudget::usual(trainer.config(), trainer.steps())).unwrap();
        pocketnerf_formats::write(&finished.model(), &About::default(), Precision::I8).unwrap()
    };
    let run = || Run::new(Length::Steps(40), Instant::now());
    let expected = end(new(), run());
    let (mut trainer, mut begun) = (new(), run());
    setup::advance(&mut trainer, &mut begun, 21).unwrap();
    let read = setup::read(&setup::save_on(&dataset, &trainer, &begun));
    assert_eq!(read.config().ndc, trainer.config().ndc);
    let (trainer, run) = read.resume(dataset, SimdLevel::detect(), Instant::now()).unwrap();
    assert!(end(trainer, run) == expected);
}
