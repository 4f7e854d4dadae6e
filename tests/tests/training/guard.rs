//! Runs that go wrong start over or end with an error, always the same way.

use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_train::trainer::{
    Diverged, Length, MAX_RESTARTS, Run, RunError, TrainConfig, Trainer, Trouble,
};

use super::setup::{advance, begin, config, dataset, resume, save, too_small, with_threads};

/// Runs to the end: the troubles on the way with the steps taken before each.
fn troubles((mut trainer, mut run): (Trainer, Run)) -> (Vec<(u32, Trouble)>, Option<Diverged>) {
    let (mut found, mut taken) = (Vec::new(), 0);
    loop {
        taken += 1;
        match run.step(&mut trainer) {
            Ok(Some(progress)) => found.extend(progress.trouble.map(|trouble| (taken, trouble))),
            Ok(None) => return (found, None),
            Err(RunError::Diverged(diverged)) => return (found, Some(diverged)),
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn a_healthy_run_is_left_alone() {
    let (mut trainer, mut run) = begin(config(), Length::Steps(700));
    assert!(advance(&mut trainer, &mut run, 700).unwrap());
    let summary = run.summary(&trainer);
    assert_eq!((trainer.steps(), summary.restarts), (700, 0));
    assert!(summary.train_psnr > 18.0, "{summary:?}");
}

#[test]
fn numbers_that_explode_end_in_an_error() {
    let config = TrainConfig { network_rate: f32::INFINITY, ..config() };
    let wild = || begin(config.clone(), Length::Steps(400));
    let (found, diverged) = with_threads(1, || troubles(wild()));
    let diverged = diverged.unwrap();
    assert_eq!(found.len(), MAX_RESTARTS as usize);
    assert!(found.iter().all(|(_, trouble)| *trouble == Trouble::NotFinite));
    assert_eq!((diverged.trouble, diverged.restarts), (Trouble::NotFinite, MAX_RESTARTS));
    let text = diverged.to_string();
    assert!(text.starts_with("training failed at step ") && !text.contains('\n'), "{text}");
    // The same steps, whoever works.
    assert_eq!(with_threads(7, || troubles(wild())), (found, Some(diverged)));
}

/// Runs for a little longer than the guard's patience.
fn impatient(trainer: Trainer) -> (Vec<(u32, Trouble)>, Option<Diverged>) {
    troubles((trainer, Run::new(Length::Steps(520), Instant::now())))
}

/// A box in which there is nothing.
fn elsewhere() -> TrainConfig {
    let aabb = Some([[5.0, 5.0, 5.0], [6.0, 6.0, 6.0]]);
    TrainConfig { aabb, batch_rays: Some(64), ..config() }
}

#[test]
fn a_scene_that_vanishes_ends_in_an_error() {
    let trainer = Trainer::with_prepass(dataset(), elsewhere(), SimdLevel::detect()).unwrap();
    let (found, diverged) = impatient(trainer);
    let vanished = |trouble| matches!(trouble, Trouble::Vanished { .. });
    assert_eq!(found.len(), MAX_RESTARTS as usize);
    assert!(found.iter().all(|(_, trouble)| vanished(*trouble)), "{found:?}");
    assert!(vanished(diverged.unwrap().trouble));
}

#[test]
fn learning_too_fast_ends_in_an_error() {
    // The first steps leave nothing of the density, or fill the box with it;
    // which of the two depends on the random numbers.
    let hasty = TrainConfig { network_rate: 1e3, ..config() };
    let trainer = Trainer::with_prepass(dataset(), hasty, SimdLevel::detect()).unwrap();
    let (found, diverged) = impatient(trainer);
    assert_eq!(found.len(), MAX_RESTARTS as usize);
    assert!(found.iter().all(|(_, trouble)| *trouble != Trouble::NotFinite), "{found:?}");
    assert_eq!(diverged.unwrap().restarts, MAX_RESTARTS);
}

#[test]
fn pictures_that_no_scene_explains_end_in_an_error() {
    let mut dataset = dataset();
    dataset.has_alpha = false;
    // Noise: no two pixels have anything to do with each other.
    let mut state = 1u32;
    for pixel in dataset.views.iter_mut().flat_map(|view| view.rgba.chunks_exact_mut(4)) {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = if state >> 31 == 0 { 0 } else { 255 };
        pixel.copy_from_slice(&[noise, noise, noise, 255]);
    }
    let trainer = Trainer::with_prepass(dataset, too_small(), SimdLevel::detect()).unwrap();
    let (found, diverged) = impatient(trainer);
    let nothing = |trouble| matches!(trouble, Trouble::NothingLearnt { .. });
    assert!(found.iter().all(|(_, trouble)| nothing(*trouble)), "{found:?}");
    assert!(nothing(diverged.unwrap().trouble));
}

#[test]
fn an_attempt_after_the_first_is_resumed_as_such() {
    let (mut trainer, mut run) = begin(elsewhere(), Length::Steps(520));
    while run.step(&mut trainer).unwrap().unwrap().trouble.is_none() {}
    assert_eq!((trainer.restarts(), trainer.steps()), (1, 0));
    run.step(&mut trainer).unwrap();
    let saved = save(&trainer, &run);
    assert_eq!(troubles(resume(&saved)), troubles((trainer, run)));
}
