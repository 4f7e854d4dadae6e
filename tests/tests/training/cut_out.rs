//! Opaque photographs before a plain background.

use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::Settings;
use pocketnerf_train::trainer::{Length, Run, TrainConfig, Trainer};

const WHITE: [f32; 3] = [1.0; 3];

/// The built-in scene as photographs on white show it.
fn on_white() -> Dataset {
    let mut dataset = builtin::dataset(Split::Train, 8);
    for pixel in dataset.views.iter_mut().flat_map(|view| view.rgba.as_chunks_mut::<4>().0) {
        let alpha = f32::from(pixel[3]) / 255.0;
        for value in &mut pixel[..3] {
            *value = (f32::from(*value) * alpha + 255.0 * (1.0 - alpha)).round() as u8;
        }
        pixel[3] = 255;
    }
    Dataset { has_alpha: false, ..dataset }
}

/// PSNR of the test views on white after some steps, and the side of the scene's box.
fn trained(dataset: Dataset) -> (f64, f32) {
    let config = TrainConfig { samples_per_step: 1 << 14, ..TrainConfig::hash_grid() };
    let mut trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
    let mut run = Run::new(Length::Steps(300), Instant::now());
    while run.step(&mut trainer).unwrap().is_some() {}
    let (model, truth) = (trainer.model(), builtin::dataset(Split::Test, 8));
    let metrics = Metrics::default();
    let score = evaluate(&model, &truth, WHITE, &Settings::default(), &metrics, |_, _, _| ());
    (score.unwrap().psnr, 1.0 / model.space.unit_map().scale)
}

/// Without silhouettes the box of the scene reaches beyond the cameras, four units away, and white
/// fog before each explains its photograph.
#[test]
fn photographs_on_white_show_the_object() {
    let (as_it_is, _) = trained(on_white());
    let mut cut_out = on_white();
    assert_eq!(cut_out.cut_out(None), Some(WHITE));
    let (cut_out, side) = trained(cut_out);
    println!("{as_it_is:.2} dB as it is, {cut_out:.2} dB cut out, box of {side:.2}");
    assert!(cut_out > 24.5 && cut_out > as_it_is + 6.0, "{cut_out}, {as_it_is}");
    assert!(side < 3.0, "{side}");
}
