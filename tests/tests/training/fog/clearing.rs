//! Cells that hold little become empty while a field learns.

use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{SectionId, open_verified};
use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::metrics::{composite_on, psnr, quantize_all};
use pocketnerf_train::picture::{Renderer, Settings};
use pocketnerf_train::trainer::checkpoint::kind;
use pocketnerf_train::trainer::{Length, Run, TrainConfig, Trainer};

use crate::setup::{advance, finish, read, save_on};

const BOX: [[f32; 3]; 2] = [[-2.0, -1.8, -1.2], [2.0, 1.8, 1.2]];

fn begun(dataset: &Dataset, clear_fog: bool, steps: u32) -> (Trainer, Run) {
    let samples_per_step = 1 << 13;
    let config = TrainConfig {
        aabb: Some(BOX),
        samples_per_step,
        samples_per_side: 160.0,
        clear_fog,
        ..TrainConfig::hash_grid()
    };
    let trainer = Trainer::with_prepass(dataset.clone(), config, SimdLevel::detect()).unwrap();
    (trainer, Run::new(Length::Steps(steps), Instant::now()))
}

/// The model file at the end, and how far its cells were cleared, as a checkpoint has it: how many
/// times as dense they are, since when, and the best PSNR since then.
fn end((mut trainer, mut run): (Trainer, Run), dataset: &Dataset) -> (Vec<u8>, Option<[f32; 3]>) {
    while !run.is_over(&trainer) {
        run.step(&mut trainer).unwrap();
    }
    let saved = save_on(dataset, &trainer, &run);
    let saved = open_verified(&saved).unwrap();
    let section = saved.container().find(SectionId::first(kind::CLEARING));
    let found = section.map(|section| {
        [0, 4, 8].map(|i| f32::from_le_bytes(section.bytes[i..i + 4].try_into().unwrap()))
    });
    // The program tells the same.
    assert_eq!(trainer.has_cleared_fog(), found.is_some_and(|[factor, ..]| factor > 1.0));
    assert_eq!(trainer.gave_up_clearing(), found.is_some_and(|[.., best]| best == f32::INFINITY));
    (finish((trainer, run)), found)
}

/// Mean PSNR of val views, and samples that they take.
fn seen(file: &[u8], scene: Scene, smaller: u32) -> (f64, u64) {
    let file = open_verified(file).unwrap();
    let mut renderer =
        Renderer::new(&file.model, &Settings { quality: 1.0, ..Settings::default() });
    let (mut sum, mut samples) = (0.0, 0);
    let views = scene.dataset(Split::Val, smaller).views;
    for view in &views {
        let picture = renderer.render(&view.camera).unwrap();
        let truth = composite_on(&view.rgba, file.model.display.background);
        sum += psnr(&picture.rgb8(&file.model.display), &quantize_all(&truth));
        samples += picture.stats.samples;
    }
    (sum / views.len() as f64, samples)
}

#[test]
fn a_place_loses_its_fog() {
    const STEPS: u32 = 1500;
    let room = Scene::Room.dataset(Split::Train, 8);
    let (foggy, none) = end(begun(&room, false, STEPS), &room);
    assert_eq!(none, None);
    let (clear, found) = end(begun(&room, true, STEPS), &room);
    let [factor, since, best] = found.unwrap();
    assert!((factor, best.is_finite()) == (8.0, true) && since < 0.5, "{factor} {since} {best}");
    let [foggy, cleared] = [&foggy, &clear].map(|file| seen(file, Scene::Room, 8));
    println!("{foggy:?} {cleared:?}");
    assert!(cleared.0 > foggy.0 && 4 * cleared.1 < foggy.1, "{foggy:?} {cleared:?}");
    // Half way, saved and resumed: the same bytes.
    let (mut trainer, mut run) = begun(&room, true, STEPS);
    advance(&mut trainer, &mut run, STEPS * 6 / 10).unwrap();
    let read = read(&save_on(&room, &trainer, &run));
    let resumed = read.resume(room.clone(), SimdLevel::detect(), Instant::now()).unwrap();
    assert!(end(resumed, &room).0 == clear);
}

/// Without its cells, training views become worse at once: they come back.
#[test]
fn smoke_stays() {
    const STEPS: u32 = 1100;
    let smoke = Scene::Fog.dataset(Split::Train, 8);
    let (plain, _) = end(begun(&smoke, false, STEPS), &smoke);
    let (tried, found) = end(begun(&smoke, true, STEPS), &smoke);
    assert_eq!(found, Some([1.0, 1.0, f32::INFINITY]));
    let [plain, tried] = [&plain, &tried].map(|file| seen(file, Scene::Fog, 8).0);
    assert!(tried > plain - 0.3, "{plain} {tried}");
}
