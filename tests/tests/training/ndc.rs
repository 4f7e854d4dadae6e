//! A forward-facing capture, learnt in normalised device coordinates.

use std::path::Path;
use std::time::Instant;

use pocketnerf_core::{SimdLevel, Space};
use pocketnerf_formats::{About, Precision};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::picture::Settings;
use pocketnerf_train::trainer::checkpoint::{self, TrainedOn};
use pocketnerf_train::trainer::{Checkpoint, Length, Run, TrainConfig, Trainer, ndc_of};

use super::setup;

/// Nothing is nearer to the cameras than this, of those four units away.
const NEAR: f32 = 2.5;

/// The views of the built-in scene that look about the same way as training view 30, in
/// the coordinates of its camera.
fn forward_facing(split: Split) -> Dataset {
    let pose = builtin::dataset(Split::Train, 40).views[30].camera.camera_to_world;
    let mut dataset = builtin::dataset(split, 8);
    for view in &mut dataset.views {
        let from = view.camera.camera_to_world;
        let to = &mut view.camera.camera_to_world;
        // The inverse of a rotation is its transpose.
        for row in 0..3 {
            for column in 0..4 {
                let own = |r: usize| from[4 * r + column] - [0.0, pose[4 * r + 3]][column / 3];
                to[4 * row + column] = (0..3).map(|r| pose[4 * r + row] * own(r)).sum();
            }
        }
    }
    dataset.views.retain(|view| view.camera.camera_to_world[10] > std::env::var("COS").unwrap().parse().unwrap());
    dataset
}

fn config(dataset: &Dataset) -> TrainConfig {
    let cameras: Vec<_> = dataset.views.iter().map(|view| view.camera).collect();
    let ndc = ndc_of(&cameras, NEAR).unwrap();
    TrainConfig { aabb: None, ndc: Some(ndc), ..setup::config() }
}

#[test]
fn views_between_are_learnt() {
    let (dataset, held_out) = (forward_facing(Split::Train), forward_facing(Split::Test));
    assert!(dataset.views.len() >= 8 && !held_out.views.is_empty());
    let config = TrainConfig {
        occupancy_resolution: 64,
        samples_per_side: std::env::var("SPS").unwrap().parse().unwrap(),
        ..config(&dataset)
    };
    let config = if std::env::var("BOX").is_ok() { TrainConfig { ndc: None, ..config } } else { config };
    println!("{:?} {}", config.ndc, dataset.views.len());
    let mut trainer = Trainer::new(dataset, config, SimdLevel::detect()).unwrap();
    let mut run = Run::new(Length::Steps(std::env::var("STEPS").unwrap().parse().unwrap()), Instant::now());
    while run.step(&mut trainer).unwrap().is_some() {}
    let finished = trainer.finished(SimdLevel::detect()).unwrap();
    let bytes =
        pocketnerf_formats::write(&finished.model(), &About::default(), Precision::I8).unwrap();
    let file = pocketnerf_formats::open_verified(&bytes).unwrap();
    //assert!(matches!(file.model.space, Space::Ndc(ndc) if ndc.near == NEAR));
    let found = evaluate(&file.model, &held_out, [1.0; 3], &Settings::default(), |_, _, _| ());
    let psnr = found.unwrap().psnr;
    println!("{psnr} {}", run.summary(&trainer).train_psnr);
    assert!(psnr > 21.0, "{psnr} dB");
    // Depths are those of the scene: of what is opaque, most within a fifth of a unit.
    let settings = Settings { depth: true, ..Settings::default() };
    let (mut near, mut all) = (0, 0);
    for view in &held_out.views {
        let picture =
            pocketnerf_train::picture::render(&file.model, &view.camera, &settings).unwrap();
        let depths = view.depth.as_ref().unwrap().iter().zip(&picture.depth);
        for ((truth, found), rgba) in depths.zip(picture.rgba.chunks(4)) {
            if truth.is_finite() && rgba[3] > 0.9 {
                all += 1;
                near += u32::from((truth - found).abs() < 0.2);
            }
        }
    }
    assert!(all > 100 && near * 10 > all * 8, "{near} of {all}");
}

#[test]
fn an_interruption_leaves_no_trace() {
    let dataset = forward_facing(Split::Train);
    let new = || Trainer::new(dataset.clone(), config(&dataset), SimdLevel::detect()).unwrap();
    let end = |mut trainer: Trainer, mut run: Run| {
        while run.step(&mut trainer).unwrap().is_some() {}
        let finished = trainer.finished(SimdLevel::detect()).unwrap();
        pocketnerf_formats::write(&finished.model(), &About::default(), Precision::I8).unwrap()
    };
    let run = || Run::new(Length::Steps(40), Instant::now());
    let expected = end(new(), run());
    let (mut trainer, mut begun) = (new(), run());
    setup::advance(&mut trainer, &mut begun, 21).unwrap();
    let trained_on = TrainedOn { fingerprint: dataset.fingerprint(), downscale_factor: 1 };
    let saved = checkpoint::write(&trainer, &begun, trained_on, &About::default()).unwrap();
    let read = Checkpoint::from_bytes(Path::new("run.ckpt.pnerf"), &saved).unwrap();
    assert_eq!(read.config().ndc, trainer.config().ndc);
    let (trainer, run) = read.resume(dataset, SimdLevel::detect(), Instant::now()).unwrap();
    assert!(end(trainer, run) == expected);
}
