//! Which files are read.

use pocketnerf_train::dataset::{LoadOptions, Split, inspect, load, load_with};

use super::all;
use super::fixture::{Capture, image};
use crate::fixture::Folder;

#[test]
fn text_and_binary_are_the_same() {
    let mut capture = Capture::around();
    let numbers = [8.25, 9.5, 4.125, 2.0, 0.1, -0.05, 1e-3, -1e-4];
    capture.cameras = vec![Capture::camera("OPENCV", &numbers)];
    let binary = capture.folder();
    let text = Folder::new();
    capture.write_images(&text, "images", [8, 4]);
    capture.write_text(&text, "sparse/0");
    let [a, b] = [&binary, &text].map(|folder| all(folder, 1));
    assert_eq!(a.fingerprint(), b.fingerprint());
    assert_eq!(a.notes, b.notes);
    // Lines that are empty may be missing, and lines may end as on Windows.
    let [cameras, images, points] = capture.text();
    assert!(images.contains("\n\n"));
    text.write("sparse/0/cameras.txt", cameras.replace('\n', "\r\n"));
    text.write("sparse/0/images.txt", images.replace("\n\n", "\n").replace('\n', "\r\n"));
    text.write("sparse/0/points3D.txt", points.trim_end());
    assert_eq!(all(&text, 1).fingerprint(), a.fingerprint());
}

#[test]
fn places_of_models() {
    let capture = Capture::around();
    let expected = all(&capture.folder(), 1).fingerprint();
    for place in ["sparse/0", "sparse", "colmap/sparse/0", "colmap/sparse", "."] {
        let folder = Folder::new();
        capture.write_images(&folder, "images", [8, 4]);
        capture.write_binary(&folder, place);
        // What newer versions write too.
        folder.write(&format!("{place}/rigs.bin"), "?");
        folder.write(&format!("{place}/frames.bin"), "?");
        assert_eq!(all(&folder, 1).fingerprint(), expected, "{place}");
    }
    // Images beside the model's folder, without one of their own.
    let folder = Folder::new();
    capture.write_images(&folder, ".", [8, 4]);
    capture.write_binary(&folder, "sparse/0");
    assert_eq!(all(&folder, 1).views[2].name, "sub/c d.png");
}

#[test]
fn the_model_with_the_most_images() {
    let capture = Capture::around();
    let folder = capture.folder();
    let mut small = capture.clone();
    small.images.truncate(1);
    small.write_binary(&folder, "sparse/0");
    capture.write_binary(&folder, "sparse/10");
    small.write_text(&folder, "sparse/2");
    let dataset = all(&folder, 1);
    assert_eq!(dataset.views.len(), 3);
    assert_eq!(
        dataset.notes[0],
        "3 models, of which sparse/10 has the most images, 3, and is taken (sparse/0 1, sparse/2 1)"
    );
}

#[test]
fn one_in_eight_by_name_is_held_out() {
    let mut capture = Capture::around();
    let at = |i: u32| format!("{i}.png");
    let place = |i: u32| image(i, &at(i), [f64::from(i), -2.0, 3.0], 0.0);
    capture.images = (1..=10).map(place).collect();
    let folder = capture.folder();
    let names = |split| {
        let dataset = load(folder.path(), split, 1).unwrap();
        dataset.views.into_iter().map(|view| view.name).collect::<Vec<_>>()
    };
    // 1, 10, 2, 3, and so on: the first and the ninth.
    assert_eq!(names(Split::Test), ["images/1.png", "images/8.png"]);
    assert_eq!(names(Split::Val), names(Split::Test));
    assert_eq!(names(Split::Train).len(), 8);
    let options = LoadOptions { hold_every: 5, ..LoadOptions::default() };
    assert_eq!(load_with(folder.path(), Split::Test, &options).unwrap().views.len(), 2);
}

#[test]
fn images_that_are_missing_and_images_that_are_not_registered() {
    let folder = Capture::around().folder();
    folder.remove("images/b.png");
    folder.image("images/sub/blurred.png", [8, 4], 0);
    folder.image("images/zzz.JPG.png", [8, 4], 0);
    let dataset = all(&folder, 1);
    let names: Vec<_> = dataset.views.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(names, ["images/a.png", "images/sub/c d.png"]);
    let images = folder.path().join("sparse/0/images.bin");
    assert_eq!(
        dataset.notes[1..],
        [
            format!(
                "1 of the 3 frames in {} have no image (first: images/b.png): they are left out",
                images.display()
            ),
            "2 of the 4 images in images are not registered (first: images/sub/blurred.png): they \
             are not used"
                .to_owned(),
        ]
    );
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    let report = pocketnerf_train::dataset::inspect_with(folder.path(), &options).unwrap();
    assert_eq!(report.images_left_out, ["images/b.png"]);
    // Cameras stay where they are.
    let whole = all(&Capture::around().folder(), 1);
    assert_eq!(dataset.views[1].camera, whole.views[2].camera);
}

#[test]
fn smaller_images() {
    let capture = Capture::around();
    let folder = capture.folder();
    capture.write_images(&folder, "images_2", [4, 2]);
    let of = |factor: u32| {
        let view = all(&folder, factor).views.swap_remove(0);
        (view.name, [view.camera.width, view.camera.height], view.camera.focal, view.rgba[2])
    };
    assert_eq!(of(1), ("images/a.png".to_owned(), [8, 4], [8.0; 2], 8));
    assert_eq!(of(2), ("images_2/a.png".to_owned(), [4, 2], [4.0; 2], 4));
    assert_eq!(of(4), ("images_2/a.png".to_owned(), [2, 1], [2.0; 2], 4));
    // The ending of smaller images may be another.
    std::fs::rename(folder.path().join("images_2/a.png"), folder.path().join("images_2/a.jpg"))
        .unwrap();
    assert_eq!(of(2).0, "images_2/a.jpg");
    // Full images that are smaller than their camera says.
    capture.write_images(&folder, "images", [4, 2]);
    assert_eq!(of(1), ("images/a.png".to_owned(), [4, 2], [4.0; 2], 4));
}

/// Black is ignored. The left half of the first image counts, in full size, and the first
/// pixel of a mask that is made smaller with its image.
#[test]
fn masks() {
    let capture = Capture::around();
    let folder = capture.folder();
    capture.write_images(&folder, "images_2", [4, 2]);
    let white = |is: bool| if is { [255; 3] } else { [0; 3] };
    folder.pixels("masks/a.png.png", [8, 4], |x, _| white(x < 4));
    folder.pixels("masks/sub/c d.png", [8, 4], |x, y| white(x < 3 && y < 3));
    let dataset = all(&folder, 1);
    let masks: Vec<_> = dataset.views.iter().map(|view| view.mask.clone()).collect();
    assert_eq!(masks[0].as_ref().unwrap()[..8], [255, 255, 255, 255, 0, 0, 0, 0]);
    assert_eq!(masks[1], None);
    assert!(dataset.notes[1].starts_with("1 of 3 images have no mask"), "{:?}", dataset.notes);
    // Two by two pixels of a mask of full images for one of images_2.
    let half = all(&folder, 2);
    assert_eq!(half.views[2].mask.as_ref().unwrap()[..], [255, 0, 0, 0, 0, 0, 0, 0]);
    // Masks as small as the images go first.
    folder.pixels("masks_2/sub/c d.png.png", [4, 2], |_, y| white(y == 1));
    let half = all(&folder, 2);
    assert_eq!(half.views[2].mask.as_ref().unwrap()[..], [0, 0, 0, 0, 255, 255, 255, 255]);
    folder.pixels("masks/a.png.png", [5, 4], |_, _| white(true));
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    let error = load_with(folder.path(), Split::Train, &options).unwrap_err().to_string();
    assert!(error.contains("a.png.png: 5x4 pixels, but"), "{error}");
}

#[test]
fn the_check_report() {
    let folder = Capture::around().folder();
    let report = inspect(folder.path()).unwrap();
    assert_eq!((report.format, report.hold_every), ("colmap", Some(8)));
    assert_eq!(report.recognised_by, "sparse/0/images.bin");
    let [train, val, _] = &report.splits[..] else { panic!("{report}") };
    assert_eq!((train.frames, val.frames, train.lenses.as_slice()), (2, 1, &["pinhole"][..]));
    assert_eq!(train.share_looking_at_box, Some(1.0));
    let text = report.to_string();
    assert!(text.contains("format    colmap, by sparse/0/images.bin"), "{text}");
    assert!(
        text.contains(
            "scene     box from (-0.500, -0.500, -0.500) to (0.500, 0.500, 0.500), by its points"
        ),
        "{text}"
    );
    assert!(text.contains("depths    from 0.750 to 1.250"), "{text}");
    assert!(report.has_no_end && text.contains("space     contracted"), "{text}");
}
