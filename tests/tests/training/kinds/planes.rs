//! Planes and lines that become finer while they learn.

use pocketnerf_core::AnyField;
use pocketnerf_train::field::PlanesConfig;
use pocketnerf_train::trainer::{Length, TrainConfig};

use crate::setup::{self, advance, begin, finish, read, resume, save, with_threads};

const STEPS: u32 = 40;

/// From 96 entries along an axis to 120.
fn config() -> TrainConfig {
    let mut config = TrainConfig {
        aabb: setup::config().aabb,
        occupancy_resolution: 32,
        samples_per_step: 4096,
        samples_per_side: 96.0,
        ..TrainConfig::planes()
    };
    config.field.planes_mut().unwrap().grid = PlanesConfig::new(120, 16);
    config
}

#[test]
fn threads_and_interruptions_leave_no_trace() {
    let whole = |n| with_threads(n, || finish(begin(config(), Length::Steps(STEPS))));
    let expected = whole(1);
    assert!(whole(5) == expected);
    let (mut trainer, mut run) = begin(config(), Length::Steps(STEPS));
    let mut resolutions = Vec::new();
    // Before planes become finer, between two stages, and afterwards.
    for at in [1, 6, 20] {
        let steps = at - trainer.steps();
        advance(&mut trainer, &mut run, steps).unwrap();
        let saved = save(&trainer, &run);
        let restored = read(&saved);
        assert_eq!(restored.config().field, trainer.config().field);
        let AnyField::Planes(field) = trainer.model().field else { panic!("another kind") };
        resolutions.push(field.planes.resolution);
        assert!(finish(resume(&saved)) == expected, "interrupted at {at}");
    }
    assert_eq!(resolutions, [96, 111, 120]);
}

#[test]
fn a_scene_is_learnt() {
    let (mut trainer, mut run) = begin(config(), Length::Steps(600));
    let mut first = None;
    while advance(&mut trainer, &mut run, 10).unwrap() {
        first.get_or_insert(run.summary(&trainer).train_psnr);
    }
    let (first, last) = (first.unwrap(), run.summary(&trainer).train_psnr);
    assert!(last > first + 4.0, "from {first} to {last} dB");
}
