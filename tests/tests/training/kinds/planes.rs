//! Planes and lines that become finer while they learn.

use pocketnerf_core::AnyField;
use pocketnerf_train::field::{PlanesConfig, PlanesFieldConfig};
use pocketnerf_train::trainer::{Length, TrainConfig};

use super::leaves_no_trace;
use crate::setup::{self, advance, begin};

const STEPS: u32 = 40;

/// From 96 entries along an axis to 120.
fn config() -> TrainConfig {
    let grid = PlanesConfig::new(120, 16);
    TrainConfig {
        aabb: setup::config().aabb,
        occupancy_resolution: 32,
        samples_per_step: 4096,
        samples_per_side: 96.0,
        ..TrainConfig::new(PlanesFieldConfig { grid, ..PlanesFieldConfig::default() })
    }
}

#[test]
fn threads_and_interruptions_leave_no_trace() {
    let mut resolutions = Vec::new();
    // Before planes become finer, between two stages, and afterwards.
    leaves_no_trace(&config(), STEPS, &[1, 6, 20], |trainer| {
        let AnyField::Planes(field) = trainer.model().field else { panic!("another kind") };
        resolutions.push(field.planes.resolution);
    });
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
