//! Small networks for parts of a scene.

use pocketnerf_core::AnyField;
use pocketnerf_train::field::DerfConfig;
use pocketnerf_train::trainer::{Length, TrainConfig};

use super::leaves_no_trace;
use crate::setup::{self, advance, begin};

const STEPS: u32 = 24;

fn config() -> TrainConfig {
    let mut derf = DerfConfig::default();
    derf.n_heads = 4;
    (derf.head.depth, derf.head.width, derf.head.skip, derf.head.color_width) = (2, 16, 0, 8);
    TrainConfig {
        aabb: setup::config().aabb,
        occupancy_resolution: 32,
        samples_per_side: 64.0,
        batch_rays: Some(256),
        ..TrainConfig::new(derf)
    }
}

#[test]
fn threads_and_interruptions_leave_no_trace() {
    leaves_no_trace(&config(), STEPS, &[3, 12], |_| ());
}

#[test]
fn every_head_has_a_part_of_the_scene() {
    let (mut trainer, mut run) = begin(config(), Length::Steps(400));
    let mut first = None;
    while advance(&mut trainer, &mut run, 10).unwrap() {
        first.get_or_insert(run.summary(&trainer).train_psnr);
    }
    let (first, last) = (first.unwrap(), run.summary(&trainer).train_psnr);
    assert!(last > first + 3.0, "from {first} to {last} dB");
    let model = trainer.model();
    let AnyField::Derf(field) = model.field else { panic!("another kind") };
    assert_eq!(field.n_heads(), 4);
    let occupancy = model.occupancy.unwrap();
    let n = occupancy.resolution();
    let mut counts = [0; 4];
    for cell in 0..n * n * n {
        let cell = [cell % n, cell / n % n, cell / (n * n)];
        if occupancy.cell(cell[0], cell[1], cell[2]) {
            let point = cell.map(|c| (c as f32 + 0.5) / n as f32);
            let mut nearest = [0.0];
            field.nearest([&point[..1], &point[1..2], &point[2..]], &mut nearest);
            counts[nearest[0] as usize] += 1;
        }
    }
    let all: usize = counts.iter().sum();
    assert!(counts.iter().all(|n| n * 20 > all), "{counts:?}");
}
