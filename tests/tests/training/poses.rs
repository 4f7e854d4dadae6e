//! Poses that are refined while the field learns.

use std::path::Path;
use std::time::Instant;

use glam::{Mat3, Quat, Vec3};
use pocketnerf_core::{Camera, SimdLevel};
use pocketnerf_formats::{Container, ContainerWriter};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::random::{Random, normal};
use pocketnerf_train::trainer::checkpoint::kind;
use pocketnerf_train::trainer::{Checkpoint, Length, Run, TrainConfig, Trainer};

use super::setup::{advance, begin, config, finish, resume, save, with_threads};

const STEPS: u32 = 70;

fn refining() -> TrainConfig {
    TrainConfig { refine_poses: true, ..config() }
}

fn whole(config: TrainConfig) -> Vec<u8> {
    finish(begin(config, Length::Steps(STEPS)))
}

#[test]
fn the_same_bytes_at_any_number_of_threads_and_after_interruptions() {
    let models = [1, 2, 7].map(|n| with_threads(n, || whole(refining())));
    assert!(models[0] == models[1] && models[1] == models[2]);
    assert!(whole(config()) != models[0]);
    // Before the first step, in the middle, and while parameters are averaged.
    let (mut trainer, mut run) = begin(refining(), Length::Steps(STEPS));
    for at in [0, 16, 41, 69, STEPS] {
        let steps = at - trainer.steps();
        advance(&mut trainer, &mut run, steps).unwrap();
        let saved = save(&trainer, &run);
        assert!(finish(resume(&saved)) == models[0], "interrupted at {at}");
    }
}

#[test]
fn a_checkpoint_holds_sound_corrections_or_is_refused() {
    let (mut trainer, mut run) = begin(refining(), Length::Steps(STEPS));
    advance(&mut trainer, &mut run, 20).unwrap();
    let saved = save(&trainer, &run);
    let with = |kind: u32, change: fn(&mut Vec<u8>)| {
        let mut writer = ContainerWriter::new();
        for section in Container::open(&saved).unwrap().sections() {
            let mut bytes = section.bytes.to_vec();
            if section.id.kind == kind {
                change(&mut bytes);
            }
            writer.add(section.id, section.version, section.is_critical(), bytes);
        }
        Checkpoint::from_bytes(Path::new("run.ckpt.pnerf"), &writer.finish().unwrap())
    };
    assert!(with(kind::POSES, |_| ()).unwrap().config().refine_poses);
    let not_a_number = |bytes: &mut Vec<u8>| bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let negative = |bytes: &mut Vec<u8>| bytes[..4].copy_from_slice(&(-1f32).to_le_bytes());
    let shorter = |bytes: &mut Vec<u8>| bytes.truncate(bytes.len() - 4);
    for (kind, change) in [
        (kind::POSES, not_a_number as fn(&mut Vec<u8>)),
        (kind::POSES, |bytes| bytes.clear()),
        (kind::POSE_MEAN, shorter),
        (kind::POSE_SQUARE, negative),
    ] {
        let line = with(kind, change).unwrap_err().to_string();
        assert!(line.contains("POSE"), "{line}");
    }
    // As many as another dataset has photographs.
    let fewer = |bytes: &mut Vec<u8>| bytes.truncate(bytes.len() - 24);
    let mut writer = ContainerWriter::new();
    for section in Container::open(&saved).unwrap().sections() {
        let mut bytes = section.bytes.to_vec();
        if [kind::POSES, kind::POSE_MEAN, kind::POSE_SQUARE].contains(&section.id.kind) {
            fewer(&mut bytes);
        }
        writer.add(section.id, section.version, section.is_critical(), bytes);
    }
    let bytes = writer.finish().unwrap();
    let checkpoint = Checkpoint::from_bytes(Path::new("run.ckpt.pnerf"), &bytes).unwrap();
    let dataset = super::setup::dataset();
    let refused = checkpoint.resume(dataset, SimdLevel::detect(), Instant::now());
    assert!(refused.unwrap_err().to_string().contains("number of photographs"));
}

/// How far apart two cameras show points of the scene, radians, on average.
fn apart(found: &Camera, truth: &Camera) -> f32 {
    let points = [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.3], [0.0, 0.5, -0.3], [0.0, -0.5, 0.0]];
    let off = points.map(|p| {
        let [a, b] = [found, truth].map(|camera| camera.project(p).unwrap());
        (a[0] - b[0]).hypot(a[1] - b[1]) / truth.focal[0]
    });
    off.iter().sum::<f32>() / off.len() as f32
}

#[test]
fn wrong_poses_are_found() {
    for (config, steps) in [(TrainConfig::hash_grid(), 600), (TrainConfig::planes(100.0), 1000)] {
        wrong_poses_are_found_by(config, steps);
    }
}

fn wrong_poses_are_found_by(config: TrainConfig, steps: u32) {
    let mut dataset = builtin::dataset(Split::Train, 4);
    let truth: Vec<Camera> = dataset.views.iter().map(|view| view.camera).collect();
    let mut random = Random::new(3, [0; 3]);
    for view in &mut dataset.views {
        let angles = Vec3::new(normal(&mut random), normal(&mut random), normal(&mut random));
        let turn = Mat3::from_quat(Quat::from_scaled_axis(0.02 * angles));
        let m = &mut view.camera.camera_to_world;
        for column in 0..3 {
            let axis = turn * Vec3::new(m[column], m[4 + column], m[8 + column]);
            (0..3).for_each(|row| m[4 * row + column] = axis[row]);
        }
    }
    let given: Vec<Camera> = dataset.views.iter().map(|view| view.camera).collect();
    let config = TrainConfig { refine_poses: true, ..config };
    let mut trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
    let mut run = Run::new(Length::Steps(steps), Instant::now());
    while run.step(&mut trainer).unwrap().is_some() {}
    let mean = |cameras: &[Camera]| {
        let off = cameras.iter().zip(&truth).map(|(found, truth)| apart(found, truth));
        off.sum::<f32>() / truth.len() as f32
    };
    let (before, after) = (mean(&given), mean(trainer.cameras()));
    println!("{before} {after}");
    assert!(before > 0.02 && after < 0.3 * before, "{before} {after}");
    // What is said of it: a turn of 0.02 about each axis.
    let sizes = trainer.pose_corrections().unwrap();
    let mean = sizes.iter().map(|[degrees, _]| degrees).sum::<f32>() / sizes.len() as f32;
    assert!((1.2..2.4).contains(&mean), "{mean} degrees");
}
