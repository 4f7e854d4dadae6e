//! A vanilla NeRF, small: trained in occupied cells, and by hierarchical sampling.

use pocketnerf_core::AnyField;
use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_formats::open_verified;
use pocketnerf_train::field::{FourierConfig, HierarchicalTraining, NerfConfig, WavesConfig};
use pocketnerf_train::trainer::{Length, TrainConfig};

use super::leaves_no_trace;
use crate::setup::{self, advance, begin, finish};

const STEPS: u32 = 24;

/// Three layers of 24.
fn small() -> NerfConfig {
    let octaves =
        |n| FourierConfig { waves: WavesConfig::Octaves { n, pi: false }, include_input: true };
    NerfConfig {
        positions: octaves(5),
        directions: Some(octaves(2)),
        depth: 3,
        width: 24,
        skip: 2,
        color_width: 12,
        ..NerfConfig::in_cells()
    }
}

/// Trained in occupied cells.
fn occupancy() -> TrainConfig {
    TrainConfig {
        aabb: setup::config().aabb,
        occupancy_resolution: 16,
        batch_rays: Some(96),
        ..TrainConfig::new(small())
    }
}

/// The same with a coarse network beside it, and random frequencies.
fn hierarchical() -> TrainConfig {
    let training = HierarchicalTraining {
        sampling: Hierarchical { n_coarse: 16, n_fine: 16, reach: Reach::Clipped },
        noise: 0.1,
        crop_steps: 4,
    };
    let positions = FourierConfig {
        waves: WavesConfig::Gaussian { n: 16, deviation: 0.7 },
        include_input: false,
    };
    let NerfConfig { muon, hierarchical, .. } = NerfConfig::hierarchical(training);
    let field = NerfConfig { positions, coarse: true, muon, hierarchical, ..small() };
    TrainConfig {
        aabb: setup::config().aabb,
        occupancy_resolution: 16,
        batch_rays: Some(96),
        samples_per_side: 48.0,
        ..TrainConfig::new(field)
    }
}

#[test]
fn threads_and_interruptions_leave_no_trace() {
    for config in [occupancy(), hierarchical()] {
        leaves_no_trace(&config, STEPS, &[0, 3, 17, STEPS], |trainer| {
            assert_eq!(trainer.config().field, config.field);
        });
    }
}

#[test]
fn both_ways_learn() {
    for config in [occupancy(), hierarchical()] {
        let config = TrainConfig { network_rate: 1e-2, batch_rays: Some(384), ..config };
        let (mut trainer, mut run) = begin(config.clone(), Length::Steps(240));
        let mut first = None;
        while advance(&mut trainer, &mut run, 10).unwrap() {
            first.get_or_insert(run.summary(&trainer).train_psnr);
        }
        let (first, last) = (first.unwrap(), run.summary(&trainer).train_psnr);
        assert!(last > first + 3.0, "from {first} to {last} dB");
        let bytes = finish((trainer, run));
        let file = open_verified(&bytes).unwrap();
        let AnyField::Nerf(field) = file.model.field else { panic!("another kind") };
        assert_eq!(field.coarse.is_some(), config.hierarchical_training().is_some());
        let sampling =
            config.hierarchical_training().unwrap_or(HierarchicalTraining::PLAIN).sampling;
        assert_eq!(file.model.hierarchical, Some(sampling));
        // Most of the box is empty, and known to be.
        let occupied = file.model.occupancy.unwrap().fraction();
        assert!((0.001..0.6).contains(&occupied), "{occupied}");
    }
}
