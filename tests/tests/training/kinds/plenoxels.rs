//! A sparse grid of voxels that becomes finer while it learns.

use pocketnerf_core::AnyField;
use pocketnerf_formats::{open_verified, pack, unpacked};
use pocketnerf_train::field::PlenoxelsConfig;
use pocketnerf_train::trainer::{Length, TrainConfig};

use super::leaves_no_trace;
use crate::setup::{self, advance, begin, finish};

const STEPS: u32 = 24;

/// From 128 voxels along the longest side to 192, because more bricks than a file numbers would be
/// around so many cells with 256.
fn config() -> TrainConfig {
    TrainConfig {
        aabb: setup::config().aabb,
        occupancy_resolution: 32,
        samples_per_step: 4096,
        samples_per_side: 96.0,
        ..TrainConfig::new(PlenoxelsConfig::default())
    }
}

#[test]
fn threads_and_interruptions_leave_no_trace() {
    let mut resolutions = Vec::new();
    // Before and after the grid becomes finer.
    leaves_no_trace(&config(), STEPS, &[3, 12], |trainer| {
        let AnyField::Plenoxels(field) = trainer.model().field else { panic!("another kind") };
        resolutions.push(field.grid.resolution);
    });
    assert_eq!(resolutions, [128, 192]);
}

#[test]
fn what_is_empty_is_not_kept() {
    let mut config = config();
    config.field = PlenoxelsConfig::new(64, 2).into();
    let (mut trainer, mut run) = begin(config, Length::Steps(600));
    let mut first = None;
    while advance(&mut trainer, &mut run, 10).unwrap() {
        first.get_or_insert(run.summary(&trainer).train_psnr);
    }
    let (first, last) = (first.unwrap(), run.summary(&trainer).train_psnr);
    assert!(last > first + 4.0, "from {first} to {last} dB");
    let bytes = finish((trainer, run));
    let file = open_verified(&bytes).unwrap();
    let AnyField::Plenoxels(field) = file.model.field else { panic!("another kind") };
    // Of all corners few have values, and few of these take bytes.
    let corners = field.grid.values.rows() as f64;
    let share = corners / 65f64.powi(3);
    assert!((0.01..0.6).contains(&share), "{share}");
    let packed = pack(&bytes).unwrap();
    assert!(4 * packed.len() < 3 * bytes.len(), "{} of {}", packed.len(), bytes.len());
    assert!(unpacked(&packed).unwrap().len() == bytes.len());
}
