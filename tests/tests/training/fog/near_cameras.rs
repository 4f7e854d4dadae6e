//! Samples near the cameras, where points or the cameras themselves say that nothing is.

use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{About, Precision};
use pocketnerf_train::builtin::{self, Scene};
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::trainer::{Length, TrainConfig, Trainer, run};

const BOX: [[f32; 3]; 2] = [[-2.0, -1.8, -1.2], [2.0, 1.8, 1.2]];

/// A model after some steps.
fn trained(dataset: Dataset) -> Vec<u8> {
    let config =
        TrainConfig { aabb: Some(BOX), samples_per_step: 4096, ..TrainConfig::hash_grid() };
    let mut trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
    run(&mut trainer, Length::Steps(5), Instant::now(), |_| ()).unwrap();
    pocketnerf_formats::write(&trainer.model(), &About::default(), Precision::F32).unwrap()
}

/// With points of the scene from this depth on.
fn known(dataset: Dataset, nearest: f32) -> Dataset {
    Dataset { bounds: Some([nearest, 9.0]), reach: Some(BOX), ..dataset }
}

/// The least distance of a camera of the room from what all of them look at, scene units.
const LEAST: f32 = 0.949_999_9;

/// In a room, samples near the cameras learn less: below what points say, or else below what the
/// cameras do. Where silhouettes say where the scene is, and where all is farther away, nothing changes.
#[test]
fn what_is_nearer_than_the_scene_learns_less() {
    let room = || Scene::Room.dataset(Split::Train, 16);
    // All else is farther away than this, and than ten times this.
    let alike = trained(known(room(), 1e-9));
    assert!(trained(known(room(), 1e-8)) == alike);
    let plain = trained(room());
    assert!(plain != alike && trained(known(room(), 0.6)) != alike);
    assert!(plain == trained(known(room(), 0.5 * LEAST)) && plain != trained(known(room(), 0.6)));
    let cut_out = || builtin::dataset(Split::Train, 16);
    assert!(trained(known(cut_out(), 4.0)) == trained(cut_out()));
}
