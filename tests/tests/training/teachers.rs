//! Fields that teach another one what lies between few photographs.

use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{About, Precision, SectionId};
use pocketnerf_train::dataset::{Dataset, Split, View};
use pocketnerf_train::picture::{self, Settings};
use pocketnerf_train::trainer::checkpoint::kind;
use pocketnerf_train::trainer::prepass::{self, Deadline, Prepared};
use pocketnerf_train::trainer::{FinishingBudget, Length, Progress, Run, TrainConfig, Trainer};

use super::ndc::{capture, config};
use super::setup::{advance, read, save_on, with_threads};

/// One photograph in two of 25.
fn few() -> Dataset {
    let mut dataset = capture(Split::Train);
    let mut number = 0;
    dataset.views.retain(|_| {
        number += 1;
        number % 2 == 0
    });
    dataset
}

fn prepared(dataset: &Dataset) -> Prepared {
    let config = TrainConfig { samples_per_side: 128.0, ..config(dataset) };
    prepass::run(dataset.clone(), config, SimdLevel::detect(), Deadline::NONE).unwrap()
}

fn taught(dataset: &Dataset, n: u32, steps: u32) -> Trainer {
    let (simd, length) = (SimdLevel::detect(), Length::Steps(steps));
    let taught = prepared(dataset).taught((n, length), simd, &mut |_, _| true).unwrap().unwrap();
    Trainer::from_prepared(taught, simd).unwrap()
}

/// The model file at the end, and PSNR of the training rays that the run tells.
fn end(mut trainer: Trainer, mut run: Run) -> (Vec<u8>, f64) {
    while run.step(&mut trainer).unwrap().is_some() {}
    let usual = FinishingBudget::usual(trainer.config(), trainer.steps());
    let finished = trainer.finished(usual).unwrap();
    let bytes = pocketnerf_formats::write(&finished.model(), &About::default(), Precision::I8);
    (bytes.unwrap(), run.summary(&trainer).train_psnr)
}

/// What a model shows of views, 8-bit.
fn pictures(file: &[u8], views: &Dataset) -> Vec<Vec<u8>> {
    let file = pocketnerf_formats::open_verified(file).unwrap();
    let rgb = |view: &View| {
        let picture = picture::render(&file.model, &view.camera, &Settings::default()).unwrap();
        picture.rgb8(&file.model.display)
    };
    views.views.iter().map(rgb).collect()
}

/// The mean of some models' pictures.
fn mean(models: &[Vec<Vec<u8>>]) -> Vec<Vec<u8>> {
    let pixel = |view: usize, i: usize| {
        let sum: usize = models.iter().map(|pictures| usize::from(pictures[view][i])).sum();
        ((sum + models.len() / 2) / models.len()) as u8
    };
    let views = 0..models[0].len();
    views.map(|view| (0..models[0][view].len()).map(|i| pixel(view, i)).collect()).collect()
}

/// Mean squared difference of pictures, in 8-bit values.
fn apart(a: &[Vec<u8>], b: &[Vec<u8>]) -> f64 {
    let values = a.iter().flatten().zip(b.iter().flatten());
    let (sum, n) = values
        .fold((0.0, 0.0), |(sum, n), (a, b)| (sum + f64::from(a.abs_diff(*b)).powi(2), n + 1.0));
    sum / n
}

#[test]
fn between_photographs_a_model_shows_the_mean_of_its_teachers() {
    const STEPS: u32 = 700;
    let (dataset, between) = (few(), capture(Split::Test));
    let run = || Run::new(Length::Steps(STEPS), Instant::now());
    let with = taught(&dataset, 2, STEPS);
    // A checkpoint has the teachers' model files.
    let saved = save_on(&dataset, &with, &run());
    let saved = pocketnerf_formats::open_verified(&saved).unwrap();
    let teachers = [0, 1].map(|index| {
        let id = SectionId { kind: kind::TEACHER, index };
        pictures(saved.container().find(id).unwrap().bytes, &between)
    });
    let mean = mean(&teachers);
    let (alone, own) = end(taught(&dataset, 0, STEPS), run());
    let (with, of_photographs) = end(with, run());
    let [alone, with] = [alone, with].map(|file| apart(&pictures(&file, &between), &mean));
    println!("{alone} {with}; photographs {own} {of_photographs}");
    assert!(with < 0.75 * alone, "{with} {alone}");
    // The run tells of photographs alone.
    assert!(of_photographs < own + 0.5, "{own} {of_photographs}");
}

#[test]
fn the_same_bytes_at_any_number_of_threads_and_after_an_interruption() {
    let dataset = few();
    let whole = || end(taught(&dataset, 2, 30), Run::new(Length::Steps(40), Instant::now())).0;
    let models = [1, 3].map(|n| with_threads(n, whole));
    assert!(models[0] == models[1]);
    let (mut trainer, mut run) =
        (taught(&dataset, 2, 30), Run::new(Length::Steps(40), Instant::now()));
    assert_eq!((trainer.n_teachers(), trainer.cameras().len()), (2, dataset.views.len()));
    advance(&mut trainer, &mut run, 21).unwrap();
    let read = read(&save_on(&dataset, &trainer, &run));
    assert_eq!(read.n_teachers(), 2);
    let (trainer, run) = read.resume(dataset.clone(), SimdLevel::detect(), Instant::now()).unwrap();
    assert!(end(trainer, run).0 == models[0]);
}

#[test]
fn teachers_are_trained_one_after_the_other_until_nobody_wants_them() {
    let dataset = few();
    let taught = |most: usize| {
        let mut seen = Vec::new();
        let mut on_step = |number: u32, progress: &Progress| {
            seen.push((number, progress.step));
            seen.len() < most
        };
        let length = Length::Steps(3);
        let taught = prepared(&dataset).taught((2, length), SimdLevel::detect(), &mut on_step);
        (taught.unwrap().is_some(), seen)
    };
    let all = vec![(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)];
    assert_eq!(taught(99), (true, all.clone()));
    assert_eq!(taught(4), (false, all[..4].to_vec()));
}
