//! `transforms.json` of instant-ngp and nerfstudio.

mod nerfstudio;
mod refusals;

use pocketnerf_train::dataset::{LoadOptions, Split, View, inspect, load, load_with};

use crate::fixture::{Folder, POSE, near, unit};

/// A camera for images of 8x4 pixels.
const CAMERA: &str = r#""fl_x": 4, "fl_y": 4, "cx": 4, "cy": 2, "w": 8, "h": 4"#;

/// Images of 4x2 pixels, half of what the camera says, and a `transforms.json` that lists
/// all of them.
fn scene(camera: &str, images: &[&str]) -> Folder {
    let folder = Folder::new();
    images.iter().for_each(|name| folder.image(name, [4, 2], 0));
    write(&folder, camera, &frames(images, ""));
    folder
}

fn frames(images: &[&str], more: &str) -> String {
    let frame = |name: &&str| {
        let name = name.replace('\\', "\\\\");
        format!(r#"{{"file_path": "{name}", "transform_matrix": {POSE}{more}}}"#)
    };
    images.iter().map(frame).collect::<Vec<_>>().join(",\n")
}

fn write(folder: &Folder, camera: &str, frames: &str) {
    folder.write("transforms.json", format!("{{{camera},\n\"frames\": [{frames}]}}"));
}

/// The training view of a scene with one image, nothing held out.
fn only(folder: &Folder) -> View {
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    load_with(folder.path(), Split::Train, &options).unwrap().views.swap_remove(0)
}

#[test]
fn a_hand_computed_ray() {
    let view = only(&scene(CAMERA, &["images/a.png"]));
    assert_eq!(view.name, "images/a.png");
    // The image is half as large as the camera says: focal 2, principal point (2, 1).
    assert_eq!((view.camera.focal, view.camera.center), ([2.0, 2.0], [2.0, 1.0]));
    // At (0, -4, 1), looking along +y, z up. The centre of pixel (0, 0) is 1.5 pixels left
    // and 0.5 up of the principal point.
    let ray = view.ray(0.5, 0.5);
    assert!(near(ray.origin, [0.0, -4.0, 1.0]) && near(ray.direction, unit([-0.75, 1.0, 0.25])));
    let [x, y] = view.project([-0.75, -3.0, 1.25]).unwrap();
    assert!(near([x, y], [0.5, 0.5]));
}

#[test]
fn the_order_of_precedence() {
    // 90 degrees over 8 pixels are a focal length of 4 in them, 2 in an image half as large.
    let focal = |camera: &str, more: &str| {
        let folder = Folder::new();
        folder.image("a.png", [4, 2], 0);
        write(&folder, camera, &frames(&["a.png"], more));
        only(&folder).camera.focal
    };
    let size = r#""w": 8, "h": 4"#;
    let all = r#""x_fov": 90, "fl_x": 9, "camera_angle_x": 0.1"#;
    assert!(near(focal(&format!("{size}, {all}"), ""), [2.0, 2.0]));
    assert_eq!(focal(&format!(r#"{size}, "fl_x": 9, "camera_angle_x": 0.1"#), ""), [4.5, 4.5]);
    let angle = r#""camera_angle_x": 1.5707963267948966"#;
    assert!(near(focal(&format!("{size}, {angle}"), ""), [2.0, 2.0]));
    // Without a size, pixels are those of the image.
    assert_eq!(focal(r#""fl_x": 9, "fl_y": 7"#, ""), [9.0, 7.0]);
    assert_eq!(focal(r#""fl_y": 7"#, ""), [7.0, 7.0]);
    // A frame goes before the top.
    assert_eq!(focal(&format!("{size}, {all}"), r#", "fl_x": 6"#), [3.0, 3.0]);
    assert_eq!(focal(&format!("{size}, {all}"), r#", "fl_x": 6, "w": 4, "h": 2"#), [6.0, 6.0]);
}

#[test]
fn lenses() {
    let direction = |lens: &str, at: [f32; 2]| {
        let view = only(&scene(&format!("{CAMERA}, {lens}"), &["a.png"]));
        let ray = view.ray(at[0], at[1]);
        let p = [0, 1, 2].map(|a| ray.origin[a] + 3.0 * ray.direction[a]);
        let back = view.project(p).unwrap();
        assert!((0..2).all(|a| (back[a] - at[a]).abs() < 1e-5), "{at:?} {back:?}");
        ray.direction
    };
    // The direction 0.5 to the right is shown at 0.5 (1 + 0.1 0.25) = 0.5125, that is
    // 1.025 pixels beside the principal point (2, 1).
    let expected = unit([0.5, 1.0, 0.0]);
    assert!(near(direction(r#""k1": 0.1"#, [3.025, 1.0]), expected));
    // p2 (r² + 2 x²) = 0.01 0.75 beside it.
    assert!(near(direction(r#""p2": 0.01"#, [3.015, 1.0]), expected));
    // p1 r² = 0.01 0.25 below it.
    assert!(near(direction(r#""p1": 0.01"#, [3.0, 1.005]), expected));
    let list = r#""camera_model": "OPENCV", "distortion_params": [0.1, 0, 0, 0, 0, 0]"#;
    assert!(near(direction(list, [3.025, 1.0]), expected));
    // A fisheye shows the angle 0.5 at 0.5 (1 + 0.1 0.25).
    let expected = [0.5f32.sin(), 0.5f32.cos(), 0.0];
    for model in [r#""is_fisheye": true"#, r#""camera_model": "OPENCV_FISHEYE""#] {
        assert!(near(direction(&format!(r#"{model}, "k1": 0.1"#), [3.025, 1.0]), expected));
    }
    // A pinhole, whatever it is called.
    let view =
        only(&scene(&format!(r#"{CAMERA}, "camera_model": "PINHOLE", "k1": 0"#), &["a.png"]));
    assert_eq!(view.ray(0.5, 0.5), view.camera.ray(0.5, 0.5));
}

/// A fisheye that shows nothing beyond r = 1/√(3·0.4) = 0.9129, at 0.6086, 1.217 pixels
/// from the principal point: the corners of the picture are dark.
#[test]
fn pixels_that_see_nothing_do_not_count() {
    let lens = format!(r#"{CAMERA}, "is_fisheye": true, "k1": -0.4"#);
    let mask = only(&scene(&lens, &["a.png"])).mask.unwrap();
    assert_eq!(mask, [0, 255, 255, 0, 0, 255, 255, 0]);
}

#[test]
fn boxes() {
    let found = |keys: &str| {
        let folder = scene(&format!("{CAMERA}{keys}"), &["a.png", "b.png"]);
        load(folder.path(), Split::Train, 1).unwrap().aabb
    };
    assert_eq!(found(""), None);
    let is = |keys: &str, min: [f32; 3], max: [f32; 3]| {
        let [low, high] = found(keys).unwrap();
        assert!(near(low, min) && near(high, max), "{keys}: {low:?} {high:?}");
    };
    // (0.5 ± aabb_scale / 2 - offset) / scale, by default with 0.33 and 0.5.
    is(r#", "aabb_scale": 4"#, [-2.0 / 0.33; 3], [2.0 / 0.33; 3]);
    is(
        r#", "aabb_scale": 1, "scale": 0.5, "offset": [0.5, 0.5, 0.2]"#,
        [-1.0, -1.0, -0.4],
        [1.0, 1.0, 1.6],
    );
    is(r#", "offset": 0, "scale": 1"#, [0.0; 3], [1.0; 3]);
    is(r#", "aabb": [[0, 0, 0], [2, 1, 1]]"#, [0.0; 3], [2.0, 1.0, 1.0]);
    // Twice the cube of side 2 around (1, 0.5, 0.5).
    let twice = r#", "aabb": [[0, 0, 0], [2, 1, 1]], "aabb_scale": 2"#;
    is(twice, [-1.0, -1.5, -1.5], [3.0, 2.5, 2.5]);
    // In the world of the poses, which applied_transform has made already.
    let applied = r#", "aabb_scale": 4, "applied_scale": 7, "applied_transform": [[0, 1, 0, 9]]"#;
    is(applied, [-2.0 / 0.33; 3], [2.0 / 0.33; 3]);
}

#[test]
fn names_order_and_splits() {
    let images = ["images/10.png", "images/2.png", "images/1.png", "images/x.jpg"];
    let folder = scene(CAMERA, &images);
    write(
        &folder,
        CAMERA,
        &frames(&["./images/10", "images\\2.png", "images/1", "images/x", "images/gone.png"], ""),
    );
    let options = LoadOptions { hold_every: 2, ..LoadOptions::default() };
    let names = |split| -> Vec<String> {
        let dataset = load_with(folder.path(), split, &options).unwrap();
        dataset.views.into_iter().map(|view| view.name).collect()
    };
    assert_eq!(names(Split::Test), ["images/1.png", "images/10.png"]);
    assert_eq!(names(Split::Val), names(Split::Test));
    assert_eq!(names(Split::Train), ["images/2.png", "images/x.jpg"]);
    let notes = load(folder.path(), Split::Train, 1).unwrap().notes;
    assert!(notes[0].starts_with("1 of the 5 frames in ") && notes.len() == 1, "{notes:?}");
    assert!(notes[0].ends_with("no image (first: images/gone.png): they are left out"));

    // The file's own lists.
    let lists =
        r#", "train_filenames": ["images/1", "./images/2.png"], "test_filenames": ["images/x"]"#;
    write(
        &folder,
        &format!("{CAMERA}{lists}"),
        &frames(&["images/10", "images/2", "images/1", "images/x"], ""),
    );
    assert_eq!(names(Split::Train), ["images/1.png", "images/2.png"]);
    assert_eq!(names(Split::Test), ["images/x.jpg"]);
    assert_eq!(names(Split::Val), ["images/x.jpg"]);
    let lists = r#", "val_filenames": ["images/x"]"#;
    write(
        &folder,
        &format!("{CAMERA}{lists}"),
        &frames(&["images/10", "images/1", "images/x"], ""),
    );
    assert_eq!(names(Split::Train), ["images/1.png", "images/10.png"]);
    assert_eq!(names(Split::Test), ["images/x.jpg"]);

    // Blurred frames: 1 is not more than 0.5 times the mean of 1, 9 and 9.
    let sharpness = [("images/1", 1), ("images/2", 9), ("images/10", 9)];
    let frames = sharpness.map(|(name, s)| frames(&[name], &format!(r#", "sharpness": {s}"#)));
    let camera = format!(r#"{CAMERA}, "sharpness_discard_threshold": 0.5"#);
    write(&folder, &camera, &frames.join(","));
    assert_eq!(names(Split::Test), ["images/2.png"]);
    assert_eq!(names(Split::Train), ["images/10.png"]);
}

#[test]
fn masks_and_alpha() {
    let folder = scene(CAMERA, &["a.png", "b.png"]);
    // Black is ignored.
    folder.pixels("mask.png", [4, 2], |x, y| if (x, y) == (1, 0) { [0; 3] } else { [0, 9, 0] });
    let frame = frames(&["a.png"], r#", "mask_path": "./mask.png""#);
    write(&folder, CAMERA, &frame);
    assert_eq!(only(&folder).mask.unwrap(), [255, 0, 255, 255, 255, 255, 255, 255]);
    // Smaller: a pixel counts if all of it does.
    let options = LoadOptions { hold_every: 0, downscale_factor: 2, ..LoadOptions::default() };
    let small = load_with(folder.path(), Split::Train, &options).unwrap();
    assert_eq!(small.views[0].mask.as_deref(), Some(&[0, 255][..]));
    let report = inspect(folder.path());
    // One image, which is held out: there is no training split.
    assert_eq!(report.unwrap().splits[0].masks, 1);
    // instant-ngp's: what is not black is ignored.
    folder.pixels("dynamic_mask_b.png", [4, 2], |x, _| if x == 3 { [255; 3] } else { [0; 3] });
    write(&folder, CAMERA, &frames(&["b.png"], ""));
    assert_eq!(only(&folder).mask.unwrap(), [255, 255, 255, 0, 255, 255, 255, 0]);
    // Alpha in a file of its own, its red channel.
    folder.pixels("b.png.alpha.png", [4, 2], |x, _| [64 * x as u8, 9, 9]);
    let view = only(&folder);
    assert_eq!(view.rgba[..16], [0, 0, 0, 0, 1, 0, 0, 64, 2, 0, 0, 128, 3, 0, 0, 192]);
    // Only pixels that count make a view transparent.
    assert_eq!(view.transparent(), [6, 6]);
    let opaque = View { mask: Some(vec![0; 8]), ..view };
    assert_eq!(opaque.transparent(), [0, 0]);
}

#[test]
fn sizes_and_intrinsics_of_each_frame() {
    let folder = scene(CAMERA, &["a.png"]);
    folder.image("b.png", [2, 4], 0);
    let own = frames(&["b.png"], r#", "fl_x": 3, "w": 2, "h": 4, "cx": 1, "cy": 2"#);
    write(&folder, CAMERA, &format!("{}, {own}", frames(&["a.png"], "")));
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    let views = load_with(folder.path(), Split::Train, &options).unwrap().views;
    assert_eq!((views[1].camera.width, views[1].camera.height), (2, 4));
    assert_eq!((views[1].camera.focal, views[1].camera.center), ([3.0; 2], [1.0, 2.0]));
}

/// Split files that say more than Blender's.
#[test]
fn one_file_a_split() {
    let folder = scene(CAMERA, &["images/a.png", "images/b.png"]);
    folder.remove("transforms.json");
    let text = |name| format!("{{{CAMERA}, \"k1\": 0.1, \"frames\": [{}]}}", frames(&[name], ""));
    folder.write("transforms_train.json", text("images/a"));
    folder.write("transforms_test.json", text("images/b"));
    let train = load(folder.path(), Split::Train, 1).unwrap();
    assert_eq!((train.views.len(), train.views[0].lens.name()), (1, "opencv"));
    assert_eq!(load(folder.path(), Split::Test, 1).unwrap().views[0].name, "images/b.png");
}
