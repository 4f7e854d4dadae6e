//! The same seed and steps give the same bytes, whatever happens in between.

use std::time::{Duration, Instant};

use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{Container, ContainerWriter, open_verified};
use pocketnerf_train::trainer::checkpoint::kind;
use pocketnerf_train::trainer::{Length, TrainConfig};

use super::setup::{
    advance, begin, config, dataset, finish, per_sample, read, resume, save, with_threads,
};

const STEPS: u32 = 70;

fn whole(config: TrainConfig) -> Vec<u8> {
    finish(begin(config, Length::Steps(STEPS)))
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    for config in [config(), per_sample()] {
        let models = [1, 2, 7].map(|n| with_threads(n, || whole(config.clone())));
        assert!(models[0] == models[1] && models[1] == models[2]);
        let other = TrainConfig { seed: 1, ..config };
        assert!(whole(other) != models[0]);
    }
}

#[test]
fn an_interruption_leaves_no_trace() {
    let searching = TrainConfig { batch_rays: Some(100), aabb: None, ..config() };
    for config in [config(), per_sample(), searching] {
        let expected = with_threads(1, || whole(config.clone()));
        // At once, between two updates of the occupancy and at one, after it is
        // frozen, and when all is done.
        let (mut trainer, mut run) = begin(config, Length::Steps(STEPS));
        for (threads, at) in (1..).zip([0, 1, 16, 41, 69, STEPS]) {
            let steps = at - trainer.steps();
            advance(&mut trainer, &mut run, steps).unwrap();
            let saved = save(&trainer, &run);
            assert_eq!(read(&saved).steps(), at);
            let resumed = with_threads(threads, || finish(resume(&saved)));
            assert!(resumed == expected, "interrupted at {at}");
        }
    }
}

#[test]
fn interrupted_again_and_again() {
    let expected = whole(config());
    let (trainer, run) = begin(config(), Length::Steps(STEPS));
    let mut saved = save(&trainer, &run);
    loop {
        let (mut trainer, mut run) = resume(&saved);
        if !advance(&mut trainer, &mut run, 9).unwrap() {
            break;
        }
        saved = save(&trainer, &run);
    }
    assert!(finish(resume(&saved)) == expected);
}

/// The model that a checkpoint leads to when the section of `kind` has other bytes,
/// or, without any, is not there.
fn with(saved: &[u8], kind: u32, change: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut writer = ContainerWriter::new();
    for section in Container::open(saved).unwrap().sections() {
        let bytes = match section.id.kind == kind {
            true => change(section.bytes),
            false => section.bytes.to_vec(),
        };
        if !bytes.is_empty() {
            writer.add(section.id, section.version, section.is_critical(), bytes);
        }
    }
    finish(resume(&writer.finish().unwrap()))
}

#[test]
fn tables_are_rounded_on_as_they_were() {
    let expected = whole(config());
    let (mut trainer, mut run) = begin(config(), Length::Steps(STEPS));
    advance(&mut trainer, &mut run, 41).unwrap();
    let saved = save(&trainer, &run);
    let with_scales = |change: fn(&[u8]) -> Vec<u8>| with(&saved, kind::SCALES, change);
    assert!(with_scales(<[u8]>::to_vec) == expected);
    // Twice as coarsely: not the same run.
    assert!(with_scales(|bytes| bytes.iter().map(|byte| byte + 1).collect()) != expected);
    // From a program that did not write them down.
    open_verified(&with_scales(|_| Vec::new())).unwrap();
}

#[test]
fn rays_are_drawn_on_as_they_were() {
    let length = Length::Steps(300);
    let expected = finish(begin(config(), length));
    // Before it is known where the error is, and after.
    for at in [100, 200] {
        let (mut trainer, mut run) = begin(config(), length);
        advance(&mut trainer, &mut run, at).unwrap();
        let saved = save(&trainer, &run);
        let with_errors = |change: fn(&[u8]) -> Vec<u8>| with(&saved, kind::PIXEL_ERRORS, change);
        assert!(with_errors(<[u8]>::to_vec) == expected, "interrupted at {at}");
        // All alike once more: not the same run.
        let forget = |bytes: &[u8]| 1.0f32.to_le_bytes().repeat(bytes.len() / 4);
        assert!(with_errors(forget) != expected);
        // From a program that did not write it down.
        open_verified(&with_errors(|_| Vec::new())).unwrap();
    }
}

#[test]
fn saving_changes_nothing() {
    let (mut trainer, mut run) = begin(config(), Length::Steps(STEPS));
    while advance(&mut trainer, &mut run, 7).unwrap() {
        save(&trainer, &run);
    }
    assert!(finish((trainer, run)) == whole(config()));
}

#[test]
fn a_checkpoint_is_a_model() {
    let (mut trainer, mut run) = begin(config(), Length::Steps(STEPS));
    advance(&mut trainer, &mut run, 20).unwrap();
    let saved = save(&trainer, &run);
    let file = open_verified(&saved).unwrap();
    assert_eq!(file.model.space, trainer.model().space);
    assert_eq!(file.about.provenance.unwrap().steps, 20);
    for ((_, stored), (_, held)) in
        file.tensors().zip(pocketnerf_formats::tensors(&trainer.model().field))
    {
        assert_eq!(stored.bytes(), held.bytes());
    }
}

#[test]
fn the_plan_of_a_timed_run_goes_on() {
    // Enough time to calibrate and to go on: steps are well below a second.
    let (mut trainer, mut run) = begin(config(), Length::Seconds(8.0));
    let steps = loop {
        let progress = run.step(&mut trainer).unwrap().unwrap();
        if let Some(steps) = progress.steps {
            break steps;
        }
    };
    let checkpoint = read(&save(&trainer, &run));
    let plan = checkpoint.plan().unwrap();
    assert_eq!((checkpoint.length(), plan.end), (Length::Seconds(8.0), steps));
    assert!(plan.first >= 32 && plan.first < checkpoint.steps() && plan.end > plan.first);
    // Even where its time was over long ago, a plan is kept.
    let now = Instant::now();
    let long_ago = now.checked_sub(Duration::from_secs(60)).unwrap_or(now);
    let (trainer, run) = checkpoint.resume(dataset(), SimdLevel::detect(), long_ago).unwrap();
    assert_eq!(read(&save(&trainer, &run)).plan(), Some(plan));
    assert!(!run.is_over(&trainer));
}

#[test]
fn a_timed_run_without_a_plan_has_the_rest_of_its_time() {
    let (mut trainer, mut run) = begin(config(), Length::Seconds(1000.0));
    advance(&mut trainer, &mut run, 3).unwrap();
    let saved = save(&trainer, &run);
    assert_eq!((read(&saved).plan(), read(&saved).steps()), (None, 3));
    let (trainer, run) = resume(&saved);
    assert!(!run.is_over(&trainer));
    // No time at all: over before the first step, and after any interruption.
    let (trainer, run) = begin(config(), Length::Seconds(1e-6));
    assert!(run.is_over(&trainer));
    let (trainer, run) = resume(&save(&trainer, &run));
    assert!(run.is_over(&trainer));
}
