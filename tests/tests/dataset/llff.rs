//! LLFF captures.

use pocketnerf_core::Camera;
use pocketnerf_train::dataset::{Dataset, LoadOptions, Split, inspect, load, load_with};

use crate::fixture::{Folder, near, unit};
use crate::refusals::refusal;

/// What one image's row says.
type Row = [f64; 17];

/// A camera for pictures of 8x4 pixels with a focal length of 8: columns down, right,
/// back; position; height, width, focal.
fn row([right, down, back]: [[f64; 3]; 3], at: [f64; 3], bounds: [f64; 2]) -> Row {
    let mut row = [0.0; 17];
    for a in 0..3 {
        row[5 * a..5 * a + 4].copy_from_slice(&[down[a], right[a], back[a], at[a]]);
    }
    (row[4], row[9], row[14]) = (4.0, 8.0, 8.0);
    row[15..].copy_from_slice(&bounds);
    row
}

/// Two cameras side by side that look along +y, z up: 2 apart, around (5, 7, 9).
fn pair() -> Vec<Row> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]];
    vec![row(axes, [4.0, 7.0, 9.0], [2.0, 10.0]), row(axes, [6.0, 7.0, 9.0], [3.0, 20.0])]
}

/// A `.npy` file, byte by byte.
fn npy(version: u8, descr: &str, order: &str, shape: &str, values: &[u8]) -> Vec<u8> {
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    while !(header.len() + 11).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = vec![0x93, b'N', b'U', b'M', b'P', b'Y', version, 0];
    match version {
        1 => bytes.extend((header.len() as u16).to_le_bytes()),
        _ => bytes.extend((header.len() as u32).to_le_bytes()),
    }
    bytes.extend(header.as_bytes());
    bytes.extend(values);
    bytes
}

fn poses(rows: &[Row]) -> Vec<u8> {
    let values: Vec<u8> = rows.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    npy(1, "<f8", "False", &format!("({}, 17)", rows.len()), &values)
}

/// A capture with images of 8x4 pixels in `images` and half of that in `images_2`.
fn capture(rows: &[Row]) -> Folder {
    let folder = Folder::new();
    for i in 0..rows.len() {
        folder.image(&format!("images/{i}.png"), [8, 4], 1);
        folder.image(&format!("images_2/{i}.png"), [4, 2], 2);
    }
    folder.write("poses_bounds.npy", poses(rows));
    folder
}

/// All images.
fn all(folder: &Folder, factor: u32) -> Dataset {
    let options = LoadOptions { downscale_factor: factor, hold_every: 0, ..LoadOptions::default() };
    load_with(folder.path(), Split::Train, &options).unwrap()
}

#[test]
fn a_hand_computed_ray() {
    let folder = capture(&pair());
    let dataset = all(&folder, 2);
    assert_eq!((dataset.format, dataset.forward_facing, dataset.aabb), ("llff", true, None));
    // The nearest depth, 2, becomes 4/3: everything is 2/3 as large. The average camera,
    // between the two, is the origin and looks along -z.
    assert!(near(dataset.bounds.unwrap(), [4.0 / 3.0, 40.0 / 3.0]));
    let [left, right] = &dataset.views[..] else { panic!("{dataset:?}") };
    assert_eq!((left.name.as_str(), right.name.as_str()), ("images_2/0.png", "images_2/1.png"));
    // Focal 8 of the full image is 4 in one half as large.
    let ray = left.ray(0.5, 0.5);
    assert!(near(ray.origin, [-2.0 / 3.0, 0.0, 0.0]), "{ray:?}");
    assert!(near(ray.direction, unit([-1.5 / 4.0, 0.5 / 4.0, -1.0])), "{ray:?}");
    assert!(near(right.ray(2.0, 1.0).origin, [2.0 / 3.0, 0.0, 0.0]));
    assert!(near(right.ray(2.0, 1.0).direction, [0.0, 0.0, -1.0]));
}

#[test]
fn the_folder_that_fits() {
    let folder = capture(&pair());
    let of = |folder: &Folder, factor: u32| {
        let dataset = all(folder, factor);
        let view = &dataset.views[0];
        let camera = view.camera;
        (view.rgba[2], [camera.width, camera.height], camera.focal[0], dataset.notes.len())
    };
    assert_eq!(of(&folder, 1), (1, [8, 4], 8.0, 0));
    assert_eq!(of(&folder, 2), (2, [4, 2], 4.0, 0));
    // From images_2.
    assert_eq!(of(&folder, 4), (2, [2, 1], 2.0, 0));
    // From images: 8 / 3.
    assert_eq!(of(&folder, 3), (1, [2, 1], 2.0, 0));
    // Only small images: they are the full ones, and it is said.
    std::fs::remove_dir_all(folder.path().join("images")).unwrap();
    assert_eq!(of(&folder, 1), (2, [4, 2], 4.0, 1));
    assert_eq!(of(&folder, 2), (2, [4, 2], 4.0, 0));
    assert_eq!(
        all(&folder, 1).notes,
        ["no folder images: those in images_2 count as the full images"]
    );
}

#[test]
fn every_eighth_is_held_out() {
    let rows: Vec<Row> = (0..9).map(|i| pair()[i % 2]).collect();
    let folder = capture(&rows);
    let names = |split| -> Vec<String> {
        let dataset = load(folder.path(), split, 1).unwrap();
        dataset.views.into_iter().map(|view| view.name).collect()
    };
    assert_eq!(names(Split::Test), ["images/0.png", "images/8.png"]);
    assert_eq!(names(Split::Val), names(Split::Test));
    assert_eq!(names(Split::Train).len(), 7);
    let report = inspect(folder.path()).unwrap();
    assert_eq!((report.hold_every, report.scene_box), (Some(8), None));
    let text = report.to_string();
    assert!(text.contains("format    llff, by poses_bounds.npy"), "{text}");
    assert!(text.contains("one image in 8 is held out"), "{text}");
    assert!(text.contains("test      the images of val"), "{text}");
}

/// Four cameras around (1, 2, 3), 2 beside and 1.5 above it.
#[test]
fn a_capture_all_around() {
    let rows = [[2.0, 0.0], [0.0, 2.0], [-2.0, 0.0], [0.0, -2.0]].map(|[x, y]| {
        let eye = [1.0 + x, 2.0 + y, 4.5];
        let m = Camera::look_at(eye, [1.0, 2.0, 3.0], [0.0, 0.0, 1.0]).map(f64::from);
        let axis = |c: usize, sign: f64| [m[c], m[4 + c], m[8 + c]].map(|v| sign * v);
        let at = eye.map(f64::from);
        let mut row = row([axis(0, 1.0), axis(1, -1.0), axis(2, 1.0)], at, [1.0, 5.0]);
        // Wide: pictures show what is behind the average camera.
        row[14] = 4.0;
        row
    });
    let folder = capture(&rows);
    let dataset = all(&folder, 1);
    assert!(!dataset.forward_facing && dataset.notes[0].contains("--spherify"), "{dataset:?}");
    let options = LoadOptions { hold_every: 0, spherify: true, ..LoadOptions::default() };
    let dataset = load_with(folder.path(), Split::Train, &options).unwrap();
    // Their distance, 2.5, becomes 1; 1.5 of it is upwards.
    assert!(near(dataset.bounds.unwrap(), [0.4, 2.0]), "{:?}", dataset.bounds);
    for view in &dataset.views {
        let ray = view.ray(4.0, 2.0);
        assert!((ray.origin[2] - 0.6).abs() < 1e-5, "{ray:?}");
        // Through the origin.
        assert!((0..3).all(|a| (ray.origin[a] + ray.direction[a]).abs() < 1e-5), "{ray:?}");
    }
    let report = inspect(folder.path()).unwrap();
    assert!(!report.forward_facing && report.to_string().contains("note      the cameras look"));
}

#[test]
fn numbers_of_every_kind() {
    let folder = capture(&pair());
    let expected = all(&folder, 1).fingerprint();
    let f32s: Vec<u8> = pair().iter().flatten().flat_map(|v| (*v as f32).to_le_bytes()).collect();
    let big_endian: Vec<u8> = pair().iter().flatten().flat_map(|v| v.to_be_bytes()).collect();
    let column = |i: usize| pair().into_iter().map(move |row| row[i]);
    let columns: Vec<u8> = (0..17).flat_map(column).flat_map(f64::to_le_bytes).collect();
    for bytes in [
        npy(2, "<f4", "False", "(2, 17)", &f32s),
        npy(1, ">f8", "False", "(2, 17)", &big_endian),
        npy(3, "<f8", "True", "(2, 17)", &columns),
    ] {
        folder.write("poses_bounds.npy", bytes);
        assert_eq!(all(&folder, 1).fingerprint(), expected);
    }
}

#[test]
fn refusals() {
    let good = poses(&pair());
    let changed = |at: usize, value: f64| {
        let mut rows = pair();
        rows[1][at] = value;
        poses(&rows)
    };
    let mut scaled = pair();
    scaled[0][..3].iter_mut().for_each(|v| *v *= 2.0);
    let file = |problem: &str| format!("D/poses_bounds.npy: {problem}");
    let frame = |problem: &str| file(&format!("frame 1 (\"images/1.png\"): {problem}"));
    let values = &good[good.len() - 2 * 17 * 8..];
    for (bytes, start) in [
        (
            Vec::new(),
            file(
                "the header of .npy: it does not begin with \\x93NUMPY; expected a .npy array of \
                 f64, a row",
            ),
        ),
        (b"not an array".to_vec(), file("the header of .npy: it does not begin with")),
        (good[..7].to_vec(), file("the header of .npy ends too early: the file is cut off; expe")),
        (good[..40].to_vec(), file("the header of .npy ends too early: the file is cut off; exp")),
        (
            good[..good.len() - 8].to_vec(),
            file("the tensor: it reaches beyond the end of its storage; expected"),
        ),
        ([&good[..], &[0; 8]].concat(), file("8 bytes after the end")),
        (
            npy(9, "<f8", "False", "(2, 17)", values),
            file("the header of .npy: format version 9 where 1 to 3 were expected;"),
        ),
        (npy(1, "|O", "False", "(2, 17)", values), file("values of type |O are not read;")),
        (npy(1, "<f8", "False", "(34,)", values), file("1 dimensions where 2 were expected;")),
        (npy(1, "<f8", "False", "(17, 2)", values), file("rows of 2 numbers, expected 17;")),
        (
            npy(1, "<f8", "False", "(18446744073709551615, 17)", values),
            file("the tensor: its shape has more numbers than can be counted;"),
        ),
        (poses(&[]), file("0 rows; expected a .npy array")),
        (poses(&pair()[..1]), "D/images: 2 images, but D/poses_bounds.npy has 1 poses".to_owned()),
        (changed(3, f64::NAN), frame("the pose holds a number that is not finite")),
        (poses(&scaled), file("frame 0 (\"images/0.png\"): the pose's 3x3 part is not a rotation")),
        (changed(4, 0.0), frame("height 0, width 8 and focal length 8, expected pixels")),
        (changed(14, f64::NAN), frame("height 4, width 8 and focal length NaN")),
        (changed(15, -1.0), frame("depths from -1 to 20, expected two positive numbers")),
        (changed(16, 1.0), frame("depths from 3 to 1")),
    ] {
        let folder = capture(&pair());
        folder.write("poses_bounds.npy", bytes);
        let message = refusal(folder.path());
        assert!(message.starts_with(&start), "{message}, expected {start}");
    }
    let folder = capture(&pair());
    folder.image("images/0.png", [4, 4], 1);
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    let error = load_with(folder.path(), Split::Train, &options).unwrap_err().to_string();
    assert!(error.contains("0.png: 4x4 pixels, but its camera is for 8x4"), "{error}");
    let options = LoadOptions { spherify: true, ..options };
    let error = load_with(folder.path(), Split::Train, &options).unwrap_err().to_string();
    assert!(error.contains("--spherify needs cameras around a point"), "{error}");
    for images in ["images", "images_2"] {
        std::fs::remove_dir_all(folder.path().join(images)).unwrap();
    }
    assert!(refusal(folder.path()).starts_with("D: no folder of images; expected images, or"));
}
