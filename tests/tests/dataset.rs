//! Loading datasets: a small Blender scene with known rays, and every way in
//! which one can be wrong.

mod blender_fixture;

use std::path::Path;

use blender_fixture::{POSE, Scene, frames};
use pocketnerf_train::dataset::{DatasetError, Split, inspect, load};

/// The one-line message of a refused dataset, without the folder's name.
fn refusal(folder: &Path) -> String {
    let error = load(folder, Split::Train, 1).expect_err("refused").to_string();
    assert!(!error.contains('\n'), "one line: {error}");
    error.replace(&folder.display().to_string(), "D")
}

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
    let rgb = image::RgbImage::from_pixel(4, 2, image::Rgb([1, 2, 3]));
    assert_eq!(colors(rgb.into()), (vec![1, 2, 3, 255], false));
    let grey = image::GrayImage::from_pixel(4, 2, image::Luma([9]));
    assert_eq!(colors(grey.into()), (vec![9, 9, 9, 255], false));
}

#[test]
fn folders_that_are_no_dataset() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(refusal(&at("none")).starts_with("D: no such folder; give the folder"));
    assert!(
        refusal(folder.path()).starts_with("D: the folder is empty; expected transforms_train")
    );
    std::fs::write(at("notes.txt"), "x").unwrap();
    assert!(
        refusal(&at("notes.txt")).starts_with("D: this is a file, expected a dataset's folder")
    );
    assert!(
        refusal(folder.path()).starts_with("D: no dataset recognised; found notes.txt; expected")
    );
    std::fs::create_dir_all(at("lego")).unwrap();
    std::fs::write(at("lego/transforms_test.json"), "{}").unwrap();
    assert!(refusal(folder.path()).ends_with("\"lego\" inside it is one: give that folder"));
}

#[test]
fn other_conventions_are_named() {
    for (file, text, start) in [
        ("poses_bounds.npy", "", "D: LLFF dataset (poses_bounds.npy), which is recognised but not"),
        ("sparse", "", "D: COLMAP dataset (sparse), which"),
        ("cameras.txt", "", "D: COLMAP dataset (cameras.txt), which"),
        (
            "transforms.json",
            r#"{"fl_x": 1, "k1": 0, "frames": []}"#,
            "D: instant-ngp or nerfstudio dataset (transforms.json: it has fl_x, k1), which",
        ),
        (
            "transforms.json",
            r#"{"camera_model": "OPENCV"}"#,
            "D: nerfstudio dataset (transforms.json: it has camera_model), which",
        ),
        (
            "transforms.json",
            r#"{"camera_angle_x": 1}"#,
            "D: single-file transforms.json dataset (transforms.json), which",
        ),
        ("transforms.json", "{", "D/transforms.json:1:1: not valid JSON: EOF"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(file), text).unwrap();
        let message = refusal(folder.path());
        assert!(message.starts_with(start), "{message}");
    }
}

#[test]
fn json_files_that_are_wrong() {
    let frame =
        |pose: &str| format!(r#"[{{"file_path": "train/r_0", "transform_matrix": {pose}}}]"#);
    let good = frame(POSE);
    let with = |angle: &str, frames: &str| {
        format!("{{\"camera_angle_x\": {angle},\n\"frames\": {frames}}}")
    };
    let mirrored = POSE.replace("[1, 0, 0, 0]", "[-1, 0, 0, 0]");
    for (text, start) in [
        ("{\"frames\": [\n  {,}]}".to_owned(), ":2:4: not valid JSON: key must be a string"),
        (String::new(), ":1:0: not valid JSON: EOF"),
        ("3".to_owned(), ":1:1: invalid type: integer `3`, expected an object; expected a Blender"),
        ("{}".to_owned(), ":1:2: missing field `frames`; expected a Blender dataset: {"),
        (with("1", "{}"), ":2:10: invalid type: map, expected a sequence; expected a Blender"),
        (with("\"wide\"", &good), ":1:25: invalid type: string \"wide\", expected f64"),
        (with("1", r#"[{"file_path": "a"}]"#), ":2:30: missing field `transform_matrix`"),
        (with("1", "[]"), ": \"frames\" is empty, expected at least one frame"),
        (with("null", &good), ": no \"camera_angle_x\"; expected the horizontal field of view"),
        (
            with("40", &good),
            ": camera_angle_x is 40, expected radians from 0.01 to below pi; degrees",
        ),
        (with("0", &good), ": camera_angle_x is 0, expected radians from 0.01 to below pi"),
        (with("-1", &good), ": camera_angle_x is -1, expected"),
        (with("1", &frame("[[1, NaN]]")), ":2:57: a number is not finite; expected finite numbers"),
        (
            with("1", &frame(&POSE.replace("-4", "1e300"))),
            ": frame 0 (\"train/r_0\"): the pose holds a number that is not finite",
        ),
        (
            with("1", &frame("[[1, 0], [0, 1]]")),
            ": frame 0 (\"train/r_0\"): the pose has 2 rows of [2, 2] numbers, expected 4 rows of 4",
        ),
        (
            with("1", &frame(&mirrored)),
            ": frame 0 (\"train/r_0\"): the pose's 3x3 part is not a rotation: determinant -1.000000",
        ),
        (with("1, \"fl_x\": 3", &good), ": instant-ngp or nerfstudio dataset (it has fl_x), which"),
        (
            with("1", &good.replace("}]", r#", "mask_path": "m.png"}]"#)),
            ": nerfstudio dataset (it has mask_path), which",
        ),
    ] {
        let scene = Scene::new();
        std::fs::write(scene.path().join("transforms_train.json"), &text).unwrap();
        let message = refusal(scene.path());
        let expected = format!("D/transforms_train.json{start}");
        assert!(message.starts_with(&expected), "{text}: {message}");
    }
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
fn a_huge_json_file_is_refused_unread() {
    let scene = Scene::new();
    let file = std::fs::File::create(scene.path().join("transforms_train.json")).unwrap();
    file.set_len((256 << 20) + 1).unwrap();
    assert!(refusal(scene.path()).contains("268435457 bytes, at most 268435456 are read"));
}

#[test]
fn a_split_that_is_not_there() {
    let scene = Scene::new();
    let error = load(scene.path(), Split::Val, 1).unwrap_err();
    assert!(matches!(error, DatasetError::NoSplit { .. }));
    let message = error.to_string();
    assert!(
        message.ends_with("so there is no val split; this dataset has train, test"),
        "{message}"
    );
}

#[test]
fn images_that_are_wrong() {
    type Break = fn(&Path);
    let cases: [(Break, &str); 7] = [
        (
            |image| std::fs::remove_file(image).unwrap(),
            "D/train/r_0: no such image (nor with .png, .jpg or .jpeg added); D/transforms_train.json lists 2 frames and 1 of",
        ),
        (|image| cut(image, 60), "D/train/r_0.png: unreadable image: "),
        (
            |image| cut(image, 0),
            "D/train/r_0.png: unreadable image: the file has 0 bytes; expected",
        ),
        (
            |image| std::fs::write(image, "GIF89a and more").unwrap(),
            "D/train/r_0.png: unreadable image: neither PNG nor JPEG; expected a whole PNG or JPEG",
        ),
        (
            |image| {
                blender_fixture::write_photo(image);
                cut(image, std::fs::metadata(image).unwrap().len() - 9);
            },
            "D/train/r_0.png: unreadable image: the file is cut off",
        ),
        (|image| zero_wide(image), "D/train/r_0.png: unreadable image: "),
        (
            |image| image::RgbImage::new(5, 2).save(image).unwrap(),
            "D/train/r_0.png: 5x2 pixels, but D/train/r_1.png has 4x2; expected images of one size",
        ),
    ];
    for (spoil, start) in cases {
        let scene = Scene::new();
        spoil(&scene.path().join("train/r_0.png"));
        let message = refusal(scene.path());
        assert!(message.starts_with(start), "{message}");
    }
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
    assert!((train.fov_x_degrees - 90.0).abs() < 1e-4);
    assert_eq!(train.camera_box, [[0.0, -4.0, 1.0], [4.0, 0.0, 1.0]]);
    let look_at = train.look_at.unwrap();
    assert!(look_at.iter().zip([0.0, 0.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{look_at:?}");
    assert_eq!((test.split, test.frames, test.look_at), ("test", 1, None));
    let text = report.to_string();
    assert!(text.contains("looking at (0.000, 0.000, 1.000), from 4.000 to 4.000 away"), "{text}");

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

/// The paper's lego scene, where `POCKETNERF_DATA` says that data lies.
#[test]
fn lego() {
    let Some(data) = std::env::var_os("POCKETNERF_DATA") else {
        println!("skipped: POCKETNERF_DATA is not set");
        return;
    };
    let data = Path::new(&data);
    let dataset = load(&data.join("nerf_synthetic/lego"), Split::Test, 1).unwrap();
    assert_eq!((dataset.views.len(), dataset.has_alpha), (25, true));
    assert!(dataset.views.iter().all(|v| (v.camera.width, v.camera.height) == (800, 800)));
    let first = &dataset.views[0];
    assert_eq!(first.name, "test/r_0.png");
    assert_eq!(first.camera.position(), [0.0, 2.737_260_1, 2.959_291_7]);
    assert!((first.camera.focal[0] - 1111.111).abs() < 1e-2, "{:?}", first.camera.focal);
    // It looks at the middle of the scene.
    let ray = first.camera.ray(400.0, 400.0);
    assert!((ray.direction[1] + 0.679_030_6).abs() < 1e-6, "{ray:?}");

    let report = inspect(&data.join("nerf_synthetic/lego")).unwrap();
    let counts: Vec<_> = report.splits.iter().map(|s| (s.split, s.images_found)).collect();
    assert_eq!(counts, [("train", 100), ("val", 10), ("test", 25)]);
    for (folder, start) in
        [("transforms/fox", "instant-ngp"), ("llff/fern", "LLFF"), ("colmap/tumbler", "COLMAP")]
    {
        let folder = data.join(folder);
        assert!(refusal(&folder).starts_with(&format!("D: {start}")), "{}", refusal(&folder));
    }
}

fn cut(file: &Path, bytes: u64) {
    std::fs::OpenOptions::new().write(true).open(file).unwrap().set_len(bytes).unwrap();
}

/// A PNG whose header says 0 pixels wide, with a right checksum.
fn zero_wide(file: &Path) {
    let header: [u8; 33] = [
        0x89, b'P', b'N', b'G', 13, 10, 26, 10, 0, 0, 0, 13, b'I', b'H', b'D', b'R', 0, 0, 0, 0, 0,
        0, 0, 2, 8, 2, 0, 0, 0, 0xf9, 0x21, 0x4a, 0x4e,
    ];
    std::fs::write(file, header).unwrap();
}
