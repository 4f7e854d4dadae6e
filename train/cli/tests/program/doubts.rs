//! `pocketnerf train`: options that do not fit are said before training, and photographs that do
//! not agree after it.

use glam::Vec3;
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{self, Split, View};
use pocketnerf_train::random::{Random, normal};

use crate::place::Place;

/// Part of the lines about boxes.
const BOX: &str = "its box";

/// What is said before the first step of a run on the still life, which is 1.7 units wide and
/// reaches from -0.7 to 0.95.
fn said(options: &str, about: &str) -> Vec<String> {
    let train = "train builtin --downscale-factor 16 --exposure off --steps 1 --json --quiet";
    let result = Place::new().ok(&format!("{train} --out x.pnerf {options}"));
    let warnings = result["warnings"].as_array().unwrap().iter();
    let all = warnings.map(|line| line.as_str().unwrap().to_owned());
    all.filter(|line| line.contains(about)).collect()
}

#[test]
fn learning_rates_at_which_runs_stop_converging_are_said() {
    assert_eq!(said("--learning-rate 2", "--learning-rate"), [""; 0]);
    for times in ["4", "8"] {
        let found = said(&format!("--learning-rate {times}"), "--learning-rate");
        let expected = format!("{times}: runs may not converge");
        assert!(found.len() == 1 && found[0].contains(&expected), "{found:?}");
    }
}

#[test]
fn a_box_that_does_not_fit_is_said_before_training() {
    for options in ["", "--aabb=-1,-1,-1,1,1,1.1", "--aabb=-1.2,-1.2,-1.2,1.2,1.2,1.2"] {
        assert_eq!(said(options, BOX), [""; 0], "{options}");
    }
    let cut = said("--aabb=-1,-1,-1,0.7,1,1.1", BOX);
    assert!(cut.len() == 1 && cut[0].starts_with("the scene reaches beyond its box by"), "{cut:?}");
    // What is proposed fits.
    let box_found = cut[0].rsplit_once("give ").unwrap().1;
    assert_eq!(said(box_found, BOX), [""; 0], "{box_found}");
    let large = said("--aabb=-3,-3,-3,3,3,3", BOX);
    assert!(large.len() == 1 && large[0].starts_with("the scene fills "), "{large:?}");
}

/// What is said of the still life's photographs after these are done to.
fn said_of(options: &str, spoil: impl FnOnce(&mut Vec<View>)) -> Vec<String> {
    let place = Place::new();
    let mut photos = builtin::dataset(Split::Train, 4).views;
    spoil(&mut photos);
    std::fs::create_dir(place.path("spoilt")).unwrap();
    dataset::write(&place.path("spoilt"), Split::Train, &photos).unwrap();
    let train = "train spoilt --exposure off --profile fast --seed 0 --json --quiet";
    let result = place.ok(&format!("{train} {options} --out x.pnerf"));
    let warnings = result["warnings"].as_array().unwrap().iter();
    warnings.map(|line| line.as_str().unwrap().to_owned()).collect()
}

/// Every `nth` photograph.
fn each(photos: &mut [View], nth: usize, first: usize, spoil: impl FnMut(&mut View)) {
    photos.iter_mut().skip(first).step_by(nth).for_each(spoil);
}

#[test]
fn gaps_between_photographs_are_said_before_training() {
    let towards = Vec3::new(0.8, -0.6, 0.6).normalize();
    let found = said_of("--steps 1", |photos| {
        photos.retain(|view| {
            let from = Vec3::from(view.camera.position()).normalize();
            from.angle_between(towards).to_degrees() > 40.0
        });
    });
    assert!(found[0].starts_with("photographs leave a gap"), "{found:?}");
}

#[test]
fn planes_that_are_coarser_than_photographs_are_said() {
    let found = |entries: u32| said_of(&format!("--steps 1 --plane-resolution {entries}"), |_| {});
    let coarse = "--plane-resolution 16: expected about 100 entries for photographs of 100 pixels";
    assert!(found(16)[0].starts_with(coarse), "{:?}", found(16));
    assert!(found(34).iter().all(|line| !line.contains("--plane-resolution")));
}

#[test]
fn blurred_and_noisy_photographs_are_named() {
    let mut random = Random::new(7, [0; 3]);
    let found = said_of("--steps 1024", |photos| {
        each(photos, 8, 1, |view| {
            for pixel in view.rgba.as_chunks_mut::<4>().0.iter_mut().filter(|pixel| pixel[3] > 0) {
                for value in &mut pixel[..3] {
                    *value = (f32::from(*value) + 30.0 * normal(&mut random)).round() as u8;
                }
            }
        });
        each(photos, 8, 5, |view| {
            let (width, before) = (view.camera.width as usize, view.rgba.clone());
            for i in width + 1..before.len() / 4 - width - 1 {
                let around = (0..9).map(|k| i + k / 3 * width + k % 3 - width - 1);
                for c in 0..4 {
                    let sum: u32 = around.clone().map(|j| u32::from(before[4 * j + c])).sum();
                    view.rgba[4 * i + c] = (sum / 9) as u8;
                }
            }
        });
    });
    let [noisy, blurred] = &found[..] else { panic!("{found:?}") };
    assert!(noisy.starts_with("train/001.png and ") && noisy.contains(": noise of "), "{noisy}");
    assert!(
        blurred.starts_with("train/005.png and ") && blurred.contains(": blurred"),
        "{blurred}"
    );
}

#[test]
fn inexact_poses_and_focal_lengths_are_said() {
    const SMALL: &str = "--steps 520 --log2-hashmap-size 14 --n-levels 6 --hidden-width 16";
    let mut random = Random::new(8, [0; 3]);
    let found = said_of(SMALL, |photos| {
        for view in photos {
            // A fifth of a pixel of these along both sides: the principal point moves as poses do.
            let by = [0, 1].map(|_| 0.2 * normal(&mut random));
            let m = &mut view.camera.camera_to_world;
            let [right, up] = [[m[0], m[4], m[8]], [m[1], m[5], m[9]]];
            let distance = 4.0 / view.camera.focal[0];
            for i in 0..3 {
                m[4 * i + 3] += distance * (by[0] * right[i] + by[1] * up[i]);
            }
        }
    });
    assert!(found.len() == 1 && found[0].starts_with("photographs are shifted by"), "{found:?}");
    for (times, expected) in [(1.1, "too long"), (0.9, "too short")] {
        let found = said_of(SMALL, |photos| {
            each(photos, 1, 0, |view| view.camera.focal = view.camera.focal.map(|f| times * f));
        });
        assert!(found.len() == 1 && found[0].contains(expected), "{times}: {found:?}");
    }
}
