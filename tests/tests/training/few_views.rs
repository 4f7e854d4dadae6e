//! Eight and twelve photographs.

use std::time::Instant;

use pocketnerf_core::{Model, SimdLevel};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::Settings;
use pocketnerf_train::trainer::{FinishingBudget, Length, Run, TrainConfig, Trainer};

/// Below and behind things, where few cameras see nothing, a field makes things up, and other
/// cameras see that.
#[test]
fn what_eight_photographs_do_not_see_is_empty() {
    let gain = gain(8, 600);
    assert!(gain > 0.3, "{gain}");
}

/// From more of them, less is made up, and it takes longer to be dense.
#[test]
fn what_twelve_photographs_do_not_see_is_empty() {
    let gain = gain(12, 1200);
    assert!(gain > 0.1, "{gain}");
}

/// What other cameras gain, dB, where what so many photographs do not see is emptied after so
/// many steps.
fn gain(photographs: usize, steps: u32) -> f64 {
    let config = TrainConfig { samples_per_step: 1 << 14, ..TrainConfig::hash_grid() };
    let mut dataset = builtin::dataset(Split::Train, 4);
    dataset.thin(photographs);
    let mut trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
    let mut run = Run::new(Length::Steps(steps), Instant::now());
    while run.step(&mut trainer).unwrap().is_some() {}
    let truth = builtin::dataset(Split::Test, 4);
    let score = |model: &Model<'_>| {
        let (settings, metrics) = (Settings::default(), Metrics::default());
        evaluate(model, &truth, [1.0; 3], &settings, &metrics, |_, _, _| ()).unwrap().psnr
    };
    let finished =
        trainer.finished(FinishingBudget::usual(trainer.config(), trainer.steps())).unwrap();
    let (before, after) = (score(&trainer.model()), score(&finished.model()));
    println!("{before:.2} dB with what is made up, {after:.2} dB without");
    after - before
}
