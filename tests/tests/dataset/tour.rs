//! The default camera path stays where photographs were taken.

use std::path::Path;

use pocketnerf_core::Camera;
use pocketnerf_formats::{PhotographList, Photographs};
use pocketnerf_train::builtin::Scene;
use pocketnerf_train::cameras::{Pace, tour};
use pocketnerf_train::dataset::{Split, load};

/// Poses of a path.
const POSES: usize = 120;

fn difference(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>().sqrt()
}

fn degrees(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|i| a[i] * b[i]).sum::<f32>().clamp(-1.0, 1.0).acos().to_degrees()
}

/// Every pose of the path that a model file leads to is near one photograph: it looks along the
/// same axis up to 20 degrees, from at most 1.5 times the usual distance between neighbours. It
/// `turns_back`, or goes around.
fn stays_among(name: &str, cameras: &[Camera], turns_back: bool) {
    let nearest = |camera: &Camera| {
        let away = |other: &Camera| difference(camera.position(), other.position());
        let mut all: Vec<f32> = cameras.iter().map(away).collect();
        all.sort_by(f32::total_cmp);
        all[1]
    };
    let mut spacings: Vec<f32> = cameras.iter().map(nearest).collect();
    spacings.sort_by(f32::total_cmp);
    let spacing = spacings[spacings.len() / 2];
    let list = PhotographList::new(cameras).unwrap();
    assert!(list.view().len() <= Photographs::MOST);
    let poses: Vec<_> = list.view().poses().collect();
    let path = tour(&poses, POSES, Pace::Even).unwrap();
    let mut worst = [0.0f32; 2];
    for (i, pose) in path.iter().enumerate() {
        let camera = Camera::from_fov_x(4, 4, 1.0, *pose);
        // The photograph that is nearest by both measures.
        let away = cameras.iter().map(|other| {
            let angle = degrees(camera.axis(), other.axis());
            [angle, difference(camera.position(), other.position()) / spacing]
        });
        let share = |away: &[f32; 2]| (away[0] / 20.0).max(away[1] / 1.5);
        let nearest = away.min_by(|a, b| share(a).total_cmp(&share(b))).unwrap();
        assert!(share(&nearest) <= 1.0, "{name} {i}: {nearest:?}");
        worst = [worst[0].max(nearest[0]), worst[1].max(nearest[1])];
        let next = Camera::from_fov_x(4, 4, 1.0, path[(i + 1) % POSES]);
        let turned = degrees(camera.axis(), next.axis());
        assert!(turned < 8.0, "{name} {i}: {turned} degrees to the next");
    }
    // To and fro, a quarter of the path is where three quarters of it are.
    let [out, home] = [POSES / 4, 3 * POSES / 4].map(|i| [3, 7, 11].map(|at| path[i][at]));
    assert_eq!(difference(out, home) < 0.01 * spacing, turns_back, "{name}: {out:?} {home:?}");
    println!("{name}: at most {:.1} degrees, {:.2} spacings", worst[0], worst[1]);
}

#[test]
fn of_built_in_scenes() {
    for scene in [Scene::StillLife, Scene::Wires, Scene::Room, Scene::Village] {
        let views = scene.dataset(Split::Train, 20).views;
        stays_among(scene.name(), &views.iter().map(|view| view.camera).collect::<Vec<_>>(), false);
    }
}

#[test]
fn of_real_scenes() {
    let Some(data) = pocketnerf_tests::data() else { return };
    let scenes = [
        ("nerf_synthetic/lego", 8),
        ("llff/fern", 8),
        ("transforms/fox", 4),
        ("colmap/tumbler", 4),
    ];
    for ((scene, factor), turns_back) in scenes.into_iter().zip([true, false, true, true]) {
        let views = load(&data.join(Path::new(scene)), Split::Train, factor).unwrap().views;
        let cameras: Vec<_> = views.iter().map(|view| view.camera).collect();
        stays_among(scene, &cameras, turns_back);
    }
}
