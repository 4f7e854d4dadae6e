//! Loading datasets: small scenes of every convention with known rays, and every way in
//! which one can be wrong.

mod colmap;
mod deepvoxels;
mod fixture;
mod images;
mod lens;
mod llff;
mod mutated;
mod phone;
mod real;
mod refusals;
mod survey;
mod suspicion;
mod tour;
mod transforms;

use fixture::{Scene, cut, frames};
use pocketnerf_train::dataset::{Split, inspect, load};

#[test]
fn a_scene_with_hand_computed_rays() {
    let scene = Scene::new();
    let dataset = load(scene.path(), Split::Train, 1).unwrap();
    assert_eq!((dataset.format, dataset.split, dataset.has_alpha), ("blender", Split::Train, true));
    let names: Vec<_> = dataset.views.iter().map(|view| view.name.as_str()).collect();
    // The dataset's order, not the alphabet's.
    assert_eq!(names, ["train/r_1.png", "train/r_0.png"]);
    let view = &dataset.views[0];
    assert_eq!((view.camera.width, view.camera.height), (4, 2));
    assert_eq!(view.rgba[..8], [1, 0, 0, 255, 1, 1, 0, 0]);
    // 90° wide, 4 pixels: focal 2. The camera at (0, -4, 1) looks along +y with z up.
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    let middle = view.camera.ray(2.0, 1.0);
    assert!(near(middle.origin, [0.0, -4.0, 1.0]) && near(middle.direction, [0.0, 1.0, 0.0]));
    // The centre of pixel (0, 0) is 1.5 pixels left and 0.5 up of the middle.
    let corner = view.camera.ray(0.5, 0.5).direction;
    let n = (0.75f32 * 0.75 + 1.0 + 0.25 * 0.25).sqrt();
    assert!(near(corner, [-0.75 / n, 1.0 / n, 0.25 / n]), "{corner:?}");
}

#[test]
fn smaller_images_and_their_cameras() {
    let scene = Scene::new();
    let full = load(scene.path(), Split::Train, 1).unwrap();
    let half = load(scene.path(), Split::Train, 2).unwrap();
    let (view, camera) = (&half.views[1], half.views[1].camera);
    assert_eq!((camera.width, camera.height, view.rgba.len()), (2, 1, 8));
    assert_eq!(camera.ray(1.0, 0.5), full.views[1].camera.ray(2.0, 1.0));
    assert_eq!(camera.ray(0.5, 0.5), full.views[1].camera.ray(1.0, 1.0));
    assert_ne!(full.fingerprint(), half.fingerprint());
    assert_eq!(full.fingerprint(), load(scene.path(), Split::Train, 1).unwrap().fingerprint());
    for factor in [0, 3] {
        let error = load(scene.path(), Split::Train, factor).unwrap_err().to_string();
        assert_eq!(error, format!("downscale factor {factor}: expected 1 to 2 for images of 4x2"));
    }
}

#[test]
fn file_names_in_every_manner() {
    let scene = Scene::new();
    let names =
        ["train/r_0", "./train/r_0.png", "train\\r_0", ".\\train\\photo", "train/photo.jpg"];
    scene.photo("train/photo.jpg");
    scene.train(&frames(&names.map(|name| name.replace('\\', "\\\\"))));
    let dataset = load(scene.path(), Split::Train, 1).unwrap();
    let found: Vec<_> = dataset.views.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(
        found,
        ["train/r_0.png", "train/r_0.png", "train/r_0.png", "train/photo.jpg", "train/photo.jpg"]
    );
    // JPEG has no alpha.
    assert!(dataset.views[3].rgba.iter().skip(3).step_by(4).all(|&alpha| alpha == 255));
}

#[test]
fn pixels_of_every_kind() {
    let scene = Scene::new();
    let colors = |image: image::DynamicImage| {
        image.save(scene.path().join("train/r_0.png")).unwrap();
        scene.train(&frames(&["train/r_0"]));
        let dataset = load(scene.path(), Split::Train, 1).unwrap();
        (dataset.views[0].rgba[..4].to_vec(), dataset.has_alpha)
    };
    let deep = image::ImageBuffer::from_pixel(4, 2, image::Rgba([65535u16, 257 * 7, 128, 32768]));
    assert_eq!(colors(deep.into()), (vec![255, 7, 0, 128], true));
    // A flaw of an opaque image is no cut-out.
    let mut flawed = image::RgbaImage::from_pixel(100, 50, image::Rgba([1, 2, 3, 255]));
    for (n, cut_out) in [(1, false), (4, false), (5, true)] {
        (0..n).for_each(|x| flawed.put_pixel(x, 7, image::Rgba([1, 2, 3, 254])));
        flawed.save(scene.path().join("train/r_0.png")).unwrap();
        scene.train(&frames(&["train/r_0"]));
        let dataset = load(scene.path(), Split::Train, 1).unwrap();
        let said = dataset.notes.iter().any(|note| {
            *note
                == format!(
                    "{n} of 5000 pixels are transparent: too few for cut-outs, the images count as \
                     opaque"
                )
        });
        assert_eq!((dataset.has_alpha, said), (cut_out, !cut_out), "{:?}", dataset.notes);
    }
    let rgb = image::RgbImage::from_pixel(4, 2, image::Rgb([1, 2, 3]));
    assert_eq!(colors(rgb.into()), (vec![1, 2, 3, 255], false));
    let grey = image::GrayImage::from_pixel(4, 2, image::Luma([9]));
    assert_eq!(colors(grey.into()), (vec![9, 9, 9, 255], false));
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    let scene = Scene::new();
    let file = scene.path().join("transforms_train.json");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, format!("\u{feff}{text}")).unwrap();
    assert_eq!(load(scene.path(), Split::Train, 1).unwrap().views.len(), 2);
}

#[test]
fn the_check_report() {
    let scene = Scene::new();
    let report = inspect(scene.path()).unwrap();
    assert_eq!(report.format, "blender");
    let [train, test] = &report.splits[..] else { panic!("{report}") };
    assert_eq!(
        (train.split, train.frames, train.images_found, train.images_with_alpha),
        ("train", 2, 2, 2)
    );
    assert_eq!((train.sizes[0].width, train.sizes[0].height, train.sizes[0].images), (4, 2, 2));
    assert!((train.fov_x_degrees.unwrap() - 90.0).abs() < 1e-4);
    assert_eq!(train.camera_box, [[0.0, -4.0, 1.0], [4.0, 0.0, 1.0]]);
    let look_at = train.look_at.unwrap();
    assert!(look_at.iter().zip([0.0, 0.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{look_at:?}");
    assert_eq!((test.split, test.frames, test.look_at), ("test", 1, None));
    let text = report.to_string();
    assert!(text.contains("looking at (0.000, 0.000, 1.000), from 4.000 to 4.000 away"), "{text}");

    assert_eq!((train.lenses.as_slice(), train.masks), (&["pinhole"][..], 0));
    // The box around what the cameras look at, and both do.
    assert_eq!((report.scene_box_given, train.share_looking_at_box), (false, Some(1.0)));
    assert_eq!((report.recognised_by.as_str(), report.hold_every), ("transforms_train.json", None));

    // What is wrong with images is reported, not refused.
    std::fs::remove_file(scene.path().join("train/r_0.png")).unwrap();
    cut(&scene.path().join("train/r_1.png"), 3);
    let report = inspect(scene.path()).unwrap();
    assert_eq!(report.splits[0].images_missing, ["train/r_0"]);
    assert_eq!(report.splits[0].images_unreadable, ["train/r_1"]);
    assert!(
        report.to_string().contains("1 images found, 1 missing (first: train/r_0)"),
        "{report}"
    );
}
