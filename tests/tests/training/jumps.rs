//! Colours that jump between the training views, in models that were trained long.

use pocketnerf_core::SimdLevel;
use pocketnerf_tests::data;
use pocketnerf_train::dataset::{self, Split};
use pocketnerf_train::trainer::{Backdrop, RaySource, color_jumps};

/// A model of lego two of whose test views are white where the bucket is yellow: geometry, training
/// views and all neighbours are right.
#[test]
fn a_model_whose_views_saturate_is_found() {
    let Some(data) = data() else { return };
    let file = data.join("failures/lego-300s-seed1.pnerf");
    let Ok(bytes) = std::fs::read(&file) else {
        println!("skipped: {} is not there", file.display());
        return;
    };
    let model = pocketnerf_formats::open_verified(&bytes).unwrap().model;
    let dataset = dataset::load(&data.join("nerf_synthetic/lego"), Split::Train, 8).unwrap();
    let source = RaySource::new(dataset.views, Backdrop::Random);
    let share = color_jumps(&model, &source, SimdLevel::detect(), 0).unwrap().unwrap();
    println!("{:.3} %", 100.0 * share);
    assert!(share > 1.5e-3, "{share}");
}
