//! Real scenes, where `POCKETNERF_DATA` says that they lie.

use std::path::PathBuf;

use pocketnerf_train::dataset::{Split, inspect, load};

use crate::fixture::near;

fn data(scene: &str) -> Option<PathBuf> {
    pocketnerf_tests::data().map(|data| data.join(scene))
}

/// The lego scene of the NeRF paper.
#[test]
fn lego() {
    let Some(folder) = data("nerf_synthetic/lego") else { return };
    let dataset = load(&folder, Split::Test, 1).unwrap();
    assert_eq!((dataset.views.len(), dataset.has_alpha), (25, true));
    assert!(dataset.views.iter().all(|v| (v.camera.width, v.camera.height) == (800, 800)));
    let first = &dataset.views[0];
    assert_eq!(first.name, "test/r_0.png");
    assert_eq!(first.camera.position(), [0.0, 2.737_26, 2.959_291_7]);
    assert!((first.camera.focal[0] - 1111.111).abs() < 1e-2, "{:?}", first.camera.focal);
    // It looks at the middle of the scene.
    let ray = first.camera.ray(400.0, 400.0);
    assert!((ray.direction[1] + 0.679_030_6).abs() < 1e-6, "{ray:?}");

    let report = inspect(&folder).unwrap();
    let counts: Vec<_> = report.splits.iter().map(|s| (s.split, s.images_found)).collect();
    assert_eq!(counts, [("train", 100), ("val", 10), ("test", 25)]);
}

/// The fern of the NeRF paper: 20 photographs, here 504x378 of 4032x3024 pixels.
#[test]
fn fern() {
    let Some(folder) = data("llff/fern") else { return };
    let train = load(&folder, Split::Train, 1).unwrap();
    let test = load(&folder, Split::Test, 8).unwrap();
    assert_eq!((train.views.len(), test.views.len()), (17, 3));
    let names: Vec<_> = test.views.iter().map(|view| view.name.as_str()).collect();
    let expected = ["images_8/image000.png", "images_8/image008.png", "images_8/image016.png"];
    assert_eq!(names, expected);
    assert!(train.forward_facing && !train.has_alpha);
    let view = &test.views[0];
    assert_eq!((view.camera.width, view.camera.height), (504, 378));
    // Worked out from the file by another program: recentred, the nearest depth at 4/3.
    assert!((view.camera.focal[0] - 407.565_8).abs() < 1e-3, "{:?}", view.camera);
    assert!(near(view.camera.position(), [-0.308_100_2, 0.134_677_2, 0.039_898_77]));
    let ray = view.ray(252.0, 189.0);
    assert!(near(ray.direction, [0.090_330_61, -0.046_033_54, -0.994_847_4]), "{ray:?}");
    assert!(near(test.bounds.unwrap(), [4.0 / 3.0, 6.280_106]));
    // All look forward.
    assert!(train.views.iter().all(|v| v.ray(252.0, 189.0).direction[2] < -0.97));
    let report = inspect(&folder).unwrap();
    let counts: Vec<_> = report.splits.iter().map(|s| (s.split, s.images_found)).collect();
    assert_eq!(counts, [("train", 17), ("val", 3), ("test", 3)]);
    assert_eq!((report.forward_facing, report.hold_every), (true, Some(8)));
}

/// instant-ngp's fox: 67 frames, of which 17 have no image.
#[test]
fn fox() {
    let Some(folder) = data("transforms/fox") else { return };
    let test = load(&folder, Split::Test, 4).unwrap();
    assert_eq!((test.views.len(), test.format), (7, "instant-ngp"));
    assert_eq!(test.views[0].name, "images/0001.jpg");
    assert!(test.notes[0].starts_with("17 of the 67 frames"), "{:?}", test.notes);
    // aabb_scale 4: ±2 / 0.33.
    let [min, max] = test.aabb.unwrap();
    assert!(near(min, [-6.060_606; 3]) && near(max, [6.060_606; 3]));
    // The first image's corner pixel at full size, undistorted by another program.
    let full = load(&folder, Split::Test, 1).unwrap();
    let ray = full.views[0].ray(0.5, 0.5);
    assert!(near(ray.origin, [3.168_359_4, -5.479_49, -0.979_166_2]), "{ray:?}");
    assert!(near(ray.direction, [-0.575_371_1, 0.537_101_9, 0.616_822_2]), "{ray:?}");
    // A quarter of the size: the corner of the picture is the same.
    let [big, small] = [&full, &test].map(|d| d.views[0].ray(0.0, 0.0).direction);
    assert!(near(big, small), "{big:?} {small:?}");

    let report = inspect(&folder).unwrap();
    let counts: Vec<_> = report.splits.iter().map(|s| (s.split, s.images_found)).collect();
    assert_eq!(counts, [("train", 43), ("val", 7), ("test", 7)]);
    let train = &report.splits[0];
    assert_eq!((train.lenses.as_slice(), report.images_left_out.len()), (&["opencv"][..], 17));
    assert_eq!((report.scene_box_given, train.share_looking_at_box), (true, Some(1.0)));
}

/// A tumbler, photographed 77 times by a telephone that COLMAP found a camera for each time.
#[test]
fn tumbler() {
    let Some(folder) = data("colmap/tumbler") else { return };
    let test = load(&folder, Split::Test, 1).unwrap();
    assert_eq!((test.views.len(), test.format, test.forward_facing), (10, "colmap", false));
    let names: Vec<_> = test.views.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(names[..3], ["images/1.jpg", "images/18.jpg", "images/25.jpg"]);
    let view = &test.views[0];
    assert_eq!((view.camera.width, view.camera.height), (800, 600));
    // Worked out from the files by another program, as is what follows.
    let close = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!((view.camera.focal[0] - 589.027_1).abs() < 1e-3, "{:?}", view.camera);
    let ray = view.ray(0.5, 0.5);
    assert!(close(&ray.origin, &[0.947_356, 0.678_853, 0.121_876]), "{ray:?}");
    assert!(close(&ray.direction, &[-0.430_766, -0.836_627, 0.338_374]), "{ray:?}");
    assert!(close(&test.bounds.unwrap(), &[0.523_324_1, 3.667_776]), "{:?}", test.bounds);
    let reach = test.reach.unwrap();
    let expected =
        [-1.210_383_7, -1.957_046_6, -1.558_653_4, 1.075_120_2, 1.661_077_5, 0.999_307_5];
    assert!(close(reach.as_flattened(), &expected), "{reach:?}");

    let report = inspect(&folder).unwrap();
    let counts: Vec<_> = report.splits.iter().map(|s| (s.split, s.images_found)).collect();
    assert_eq!(counts, [("train", 67), ("val", 10), ("test", 10)]);
    assert_eq!(report.splits[0].share_looking_at_box, Some(1.0));
}
