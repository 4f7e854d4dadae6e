//! Eight photographs.

use std::time::Instant;

use pocketnerf_core::{Model, SimdLevel};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::Settings;
use pocketnerf_train::trainer::{FinishingBudget, Length, Run, TrainConfig, Trainer};

/// Below and behind things, where eight cameras see nothing, a field makes things up, and other
/// cameras see that.
#[test]
fn what_few_photographs_do_not_see_is_empty() {
    let config = TrainConfig { samples_per_step: 1 << 14, ..TrainConfig::hash_grid() };
    let mut dataset = builtin::dataset(Split::Train, 4);
    dataset.thin(8);
    let mut trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
    let mut run = Run::new(Length::Steps(600), Instant::now());
    while run.step(&mut trainer).unwrap().is_some() {}
    let truth = builtin::dataset(Split::Test, 4);
    let score = |model: &Model<'_>| {
        let (settings, metrics) = (Settings::default(), Metrics::default());
        evaluate(model, &truth, [1.0; 3], &settings, &metrics, |_, _, _| ()).unwrap().psnr
    };
    let finished = trainer.finished(FinishingBudget::usual(trainer.config())).unwrap();
    let (before, after) = (score(&trainer.model()), score(&finished.model()));
    println!("{before:.2} dB with what is made up, {after:.2} dB without");
    assert!(after > before + 0.3, "{after}, {before}");
}
