//! Pixels that masks ignore.

use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::lens::Lens;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::Settings;
use pocketnerf_train::trainer::{Length, Run, Trainer};

use crate::setup::{config, dataset, finish};

/// The views through a lens, a third of their pixels masked, and these of this colour.
fn masked(color: [u8; 4]) -> Dataset {
    let mut dataset = dataset();
    for view in &mut dataset.views {
        view.lens = Lens::open_cv([0.05, 0.0, 0.0, 0.0], [1e-3, 0.0]);
        let mask: Vec<u8> = (0..25 * 25).map(|i| u8::from(i % 25 > 7)).collect();
        for (pixel, counts) in view.rgba.as_chunks_mut::<4>().0.iter_mut().zip(&mask) {
            *pixel = if *counts == 0 { color } else { *pixel };
        }
        view.mask = Some(mask);
    }
    dataset
}

fn train(dataset: Dataset) -> Vec<u8> {
    let trainer = Trainer::with_prepass(dataset, config(), SimdLevel::detect()).unwrap();
    finish((trainer, Run::new(Length::Steps(80), Instant::now())))
}

#[test]
fn what_masks_ignore_changes_nothing() {
    let (red, clear) = (masked([255, 0, 0, 255]), masked([9, 9, 9, 0]));
    let model = train(red.clone());
    assert_eq!(model, train(clear.clone()), "learning");
    // Without the masks, it would.
    let unmasked = |mut dataset: Dataset| {
        dataset.views.iter_mut().for_each(|view| view.mask = None);
        dataset
    };
    assert_ne!(model, train(unmasked(red.clone())));
    let file = pocketnerf_formats::open_verified(&model).unwrap();
    let score = |dataset: &Dataset| {
        let settings = Settings::default();
        evaluate(&file.model, dataset, [1.0; 3], &settings, &Metrics::default(), |_, _, _| ())
            .unwrap()
    };
    let (on_red, on_clear) = (score(&red), score(&clear));
    assert_eq!(on_red.psnr, on_clear.psnr, "scores");
    assert_ne!(on_red.psnr, score(&unmasked(red)).psnr);
}
