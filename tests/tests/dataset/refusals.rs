//! Every way in which a dataset can be wrong, and the line that says so.

use std::path::Path;

use pocketnerf_train::dataset::{DatasetError, Split, load};

use crate::fixture::{self, POSE, Scene, cut};

/// The one-line message of a refused dataset, without the folder's name.
pub(crate) fn refusal(folder: &Path) -> String {
    let error = load(folder, Split::Train, 1).expect_err("refused").to_string();
    assert!(!error.contains('\n'), "one line: {error}");
    error.replace(&folder.display().to_string(), "D")
}

#[test]
fn folders_that_are_no_dataset() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(refusal(&at("none")).starts_with("D: no such folder; give the folder"));
    assert!(
        refusal(folder.path())
            .starts_with("D: the folder is empty; expected a dataset: transforms_")
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
        (with("1", r#"[{"file_path": "a"}]"#), ":2:29: missing field `transform_matrix`"),
        (with("1", "[]"), ": \"frames\" is empty, expected at least one frame"),
        (with("null", &good), ": no \"camera_angle_x\"; expected the horizontal field of view"),
        (
            with("40", &good),
            ": camera_angle_x is 40, expected radians from 0.01 to below pi; degrees",
        ),
        (with("0", &good), ": camera_angle_x is 0, expected radians from 0.01 to below pi"),
        (with("-1", &good), ": camera_angle_x is -1, expected"),
        (with("1", &frame("[[1, NaN]]")), ":2:64: a number is not finite; expected finite numbers"),
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
        // Files that say more than Blender's are read as transforms.json.
        (
            with("1, \"fl_x\": -3", &good),
            ": frame 0 (\"train/r_0\"): fl_x is -3, expected pixels above 0",
        ),
        (
            with("1", &good.replace("}]", r#", "k1": 1e300}]"#)),
            ": frame 0 (\"train/r_0\"): a lens coefficient is 1",
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
            "D/train/r_0: no such image (nor with .png, .jpg and the like added); D/transforms_train.json lists 2 frames and 1 of",
        ),
        (|image| cut(image, 60), "D/train/r_0.png: unreadable image: "),
        (
            |image| cut(image, 0),
            "D/train/r_0.png: unreadable image: the file has 0 bytes; expected",
        ),
        (
            |image| std::fs::write(image, "PNG and more").unwrap(),
            "D/train/r_0.png: unreadable image: neither PNG nor JPEG, WebP, TIFF or EXR; expected a",
        ),
        (
            |image| {
                fixture::write_photo(image);
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

/// A PNG whose header says 0 pixels wide, with a right checksum.
fn zero_wide(file: &Path) {
    let header: [u8; 33] = [
        0x89, b'P', b'N', b'G', 13, 10, 26, 10, 0, 0, 0, 13, b'I', b'H', b'D', b'R', 0, 0, 0, 0, 0,
        0, 0, 2, 8, 2, 0, 0, 0, 0xf9, 0x21, 0x4a, 0x4e,
    ];
    std::fs::write(file, header).unwrap();
}
