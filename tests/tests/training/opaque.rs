//! Opaque photographs of what is black in part.

use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::{self, Settings};
use pocketnerf_train::trainer::{Length, Run, TrainConfig, Trainer};

use crate::ndc::{capture, config};
use crate::setup::finish;

/// Nearer than this is a wall, in scene units; what it hides is five times as far away.
const WALL: f32 = 4.0;

/// Two walls, of which the near one has black spots.
fn spotted(split: Split) -> Dataset {
    let mut dataset = capture(split);
    for view in &mut dataset.views {
        let pixels = view.rgba.as_chunks_mut::<4>().0.iter_mut();
        for (pixel, depth) in pixels.zip(view.depth.as_ref().unwrap()) {
            if *depth < WALL && pixel[2] < 128 {
                *pixel = [0, 0, 0, 255];
            }
        }
    }
    dataset
}

/// The model file after 1,000 steps, learnt against a colour or none.
fn train(backdrop: Option<[f32; 3]>) -> Vec<u8> {
    let dataset = spotted(Split::Train);
    let config = TrainConfig { samples_per_side: 128.0, backdrop, ..config(&dataset) };
    let trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
    finish((trainer, Run::new(Length::Steps(1000), Instant::now())))
}

/// PSNR of held-out views on black and on white.
fn on_both(bytes: &[u8]) -> [f64; 2] {
    let file = pocketnerf_formats::open_verified(bytes).unwrap();
    assert_eq!(file.model.display.background, [0.0; 3]);
    [0.0, 1.0].map(|grey| {
        let (settings, metrics) = (Settings::default(), Metrics::default());
        evaluate(&file.model, &spotted(Split::Test), [grey; 3], &settings, &metrics, |_, _, _| ())
            .unwrap()
            .psnr
    })
}

#[test]
fn what_is_black_is_opaque_on_any_background() {
    let held_out = spotted(Split::Test);
    let bytes = train(None);
    let [on_black, on_white] = on_both(&bytes);
    assert!(on_black > 19.5 && on_white > on_black - 0.2, "{on_black} {on_white}");
    // Learnt against black, it is left out.
    let [against_black, holes] = on_both(&train(Some([0.0; 3])));
    println!("{on_black} {against_black} {holes}");
    assert!(on_black > against_black - 0.3 && holes < on_black - 5.0, "{against_black} {holes}");
    let file = pocketnerf_formats::open_verified(&bytes).unwrap();
    // It is where it is, and hides the other wall.
    let settings = Settings { depth: true, ..Settings::default() };
    let (mut right, mut all, mut opacity) = (0, 0, 0.0);
    for view in &held_out.views {
        let picture = picture::render(&file.model, &view.camera, &settings).unwrap();
        for (i, truth) in view.depth.as_ref().unwrap().iter().enumerate() {
            if *truth < WALL && view.rgba[4 * i + 2] == 0 {
                all += 1;
                right += u32::from((truth / picture.depth[i] - 1.0).abs() < 0.2);
                opacity += picture.rgba[4 * i + 3];
            }
        }
    }
    opacity /= all as f32;
    println!("{right} of {all}, {opacity}");
    assert!(right * 4 > all * 3 && opacity > 0.99, "{right} of {all}, {opacity}");
}
