//! What a window shows, without a window.

mod common;

use std::thread::sleep;
use std::time::{Duration, Instant};

use common::{STILL_LIFE, picture};
use pocketnerf_core::{Camera, ColorSpace};
use pocketnerf_formats::ModelFile;
use pocketnerf_view::paint::modes::Mode;
use pocketnerf_view::paint::{Painter, Shot};
use pocketnerf_view::show::{Next, Show};
use pocketnerf_view::view::View;

const SIZE: [u32; 2] = [160, 120];

fn show<'m>(file: &'m ModelFile<'_>) -> Show<'m> {
    let painter = Painter::new(&file.model, 2).unwrap();
    let mut show = Show::new(painter, View::new(file), Mode::Colour, 0.5, 30.0);
    show.resize(SIZE);
    show
}

/// Works until the picture is whole; how many moving pictures there were.
fn rest(show: &mut Show<'_>) -> u32 {
    let mut moving = 0;
    loop {
        match show.next() {
            Next::Now => moving += u32::from(show.work().unwrap()),
            Next::At(time) => sleep(time.saturating_duration_since(Instant::now())),
            Next::Rest => return moving,
        }
    }
}

#[test]
fn moves_settles_and_rests_at_the_picture_of_the_rust_api() {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let mut show = show(&file);
    assert!(show.work().unwrap());
    let moving = show.shown().clone();
    assert!(show.next() != Next::Rest && !show.is_at_rest());
    assert_eq!(rest(&mut show), 0);
    let camera = show.view.camera(SIZE[0], SIZE[1]);
    let expected = picture(&file, &camera, 0.5);
    assert!(show.is_at_rest() && show.shown().rgb() == expected);
    assert_eq!(show.figures.moving_psnr, moving.psnr(show.shown()));
    // At rest there is nothing to do.
    assert!(!show.work().unwrap() && show.next() == Next::Rest);
}

#[test]
fn a_linear_model_is_shown_in_srgb() {
    let mut file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let display = &mut file.model.display;
    (display.background, display.color_space) = ([0.5; 3], ColorSpace::Linear);
    let painter = Painter::new(&file.model, 1).unwrap();
    let away = Camera::look_at([0.0, 0.0, 9.0], [0.0, 0.0, 99.0], [0.0, 1.0, 0.0]);
    let camera = Camera::from_fov_x(8, 8, 0.7, away);
    for mode in [Mode::Colour, Mode::Depth, Mode::Normals, Mode::Occupancy] {
        let (picture, _) = painter.picture(&Shot { camera, mode, quality: 0.5 }).unwrap();
        // 0.5 in sRGB is 187.5 of 255.
        assert!(picture.rgb().iter().all(|byte| *byte == 188), "{mode:?}");
    }
}

#[test]
fn what_changes_while_a_picture_is_refined_begins_a_new_one() {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let mut show = show(&file);
    assert!(show.work().unwrap());
    sleep(Duration::from_millis(70));
    // The first tiles of the whole picture.
    assert!(!show.work().unwrap() && !show.is_at_rest());
    show.view.turn(0.5, 0.1);
    show.change();
    let camera = show.view.camera(SIZE[0], SIZE[1]);
    let expected = picture(&file, &camera, 0.5);
    // A picture requested in between is whole all the same.
    assert!(show.whole().unwrap().rgb() == expected);
    assert!(show.work().unwrap());
    rest(&mut show);
    assert!(show.shown().rgb() == expected);
    show.quality = 1.0;
    show.change();
    assert_eq!(rest(&mut show), 1);
    assert!(show.shown().rgb() == picture(&file, &camera, 1.0));
}

#[test]
fn a_window_without_pixels_has_nothing_to_do() {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let mut show = show(&file);
    for size in [[0, 0], [0, 5], [5, 0]] {
        show.resize(size);
        show.change();
        assert!(show.next() == Next::Rest && !show.work().unwrap());
        assert!(show.whole().unwrap().pixels.is_empty());
    }
    show.resize([1, 1]);
    rest(&mut show);
    let camera = show.view.camera(1, 1);
    assert!(show.shown().rgb() == picture(&file, &camera, 0.5));
}
