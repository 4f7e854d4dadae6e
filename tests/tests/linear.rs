//! Pictures of a model whose colours are linear light.

use pocketnerf_core::{Camera, ColorSpace, Display, Model};
use pocketnerf_tests::tiny::Tiny;
use pocketnerf_train::dataset::{Dataset, Split, View};
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::{self, Settings};

/// Its back to the scene, half of the light behind it.
fn dark() -> (Tiny, Camera) {
    let pose = Camera::look_at([0.0, 0.0, 3.0], [0.0, 0.0, 9.0], [0.0, 1.0, 0.0]);
    (Tiny::new(), Camera::from_fov_x(8, 8, 0.7, pose))
}

fn linear<'a>(model: &Model<'a>, background: [f32; 3]) -> Model<'a> {
    let display = Display { background, color_space: ColorSpace::Linear, ..model.display };
    Model { display, ..*model }
}

#[test]
fn bytes_of_a_picture_are_encoded() {
    let (tiny, camera) = dark();
    let model = linear(&tiny.hash_grid(), [0.0, 0.25, 0.5]);
    let picture = picture::render(&model, &camera, &Settings::default()).unwrap();
    assert_eq!(picture.rgb8(&model.display), [0, 137, 188].repeat(64));
    // Floating-point colours stay in the model's space.
    assert_eq!(picture.over(model.display.background), [0.0, 0.25, 0.5].repeat(64));
}

#[test]
fn scores_compare_srgb_over_the_same_background() {
    let (tiny, camera) = dark();
    let model = linear(&tiny.hash_grid(), [0.0; 3]);
    let empty = View::new("empty", camera, vec![0; 4 * 64]);
    let dataset = Dataset::new("test", "test", Split::Test, vec![empty]);
    let background = [0.2, 0.5, 1.0];
    let mut bytes = Vec::new();
    let (settings, metrics) = (Settings::default(), Metrics::default());
    let each =
        |_, picture: &[u8], truth: &[u8]| bytes = [picture, truth].map(<[u8]>::to_vec).into();
    let scores = evaluate(&model, &dataset, background, &settings, &metrics, each).unwrap();
    assert_eq!(bytes, [[51, 128, 255].repeat(64), [51, 128, 255].repeat(64)]);
    assert_eq!(scores.psnr, f64::INFINITY);
}
