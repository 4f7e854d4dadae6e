//! A copy of a dataset, and ways to spoil it.

use std::path::{Path, PathBuf};

use image::RgbaImage;
use pocketnerf_train::picture::image_file;
use serde_json::Value;

/// A pose, row after row.
pub(crate) type Pose = [[f64; 4]; 4];

/// A dataset in a folder that vanishes.
pub(crate) struct Data(tempfile::TempDir);

const FILE: &str = "transforms_train.json";

impl Data {
    pub(crate) fn copy(from: &Path) -> Self {
        let data = Self(tempfile::tempdir().unwrap());
        copy(from, data.path());
        data
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// The image of a frame.
    pub(crate) fn file(&self, i: usize) -> PathBuf {
        self.path().join(format!("train/{i:03}.png"))
    }

    /// Changes the text of the file that lists the training frames.
    pub(crate) fn text(&self, change: impl Fn(String) -> String) {
        let file = self.path().join(FILE);
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(file, change(text)).unwrap();
    }

    /// Changes what it says.
    pub(crate) fn json(&self, change: impl Fn(&mut Value)) {
        self.text(|text| {
            let mut json: Value = serde_json::from_str(&text).unwrap();
            change(&mut json);
            json.to_string()
        });
    }

    /// Changes its frames.
    pub(crate) fn frames(&self, change: impl Fn(usize, &mut Value)) {
        self.json(|json| {
            let frames = json["frames"].as_array_mut().unwrap();
            frames.iter_mut().enumerate().for_each(|(i, frame)| change(i, frame));
        });
    }

    /// Keeps some frames.
    pub(crate) fn keep(&self, keeps: impl Fn(usize, Pose) -> bool) {
        self.json(|json| {
            let frames = json["frames"].as_array_mut().unwrap();
            let mut i = 0..;
            frames.retain(|frame| keeps(i.next().unwrap(), pose(frame)));
        });
    }

    /// Changes poses.
    pub(crate) fn poses(&self, change: impl Fn(usize, Pose) -> Pose) {
        self.frames(|i, frame| {
            let pose = change(i, pose(frame));
            frame["transform_matrix"] = serde_json::to_value(pose).unwrap();
        });
    }

    /// Changes where cameras are.
    pub(crate) fn positions(&self, change: impl Fn(usize, [f64; 3]) -> [f64; 3]) {
        self.poses(|i, mut pose| {
            let position = change(i, [0, 1, 2].map(|row| pose[row][3]));
            (0..3).for_each(|row| pose[row][3] = position[row]);
            pose
        });
    }

    /// Sets keys of all frames.
    pub(crate) fn set(&self, keys: &[&str], value: f64) {
        self.frames(|_, frame| keys.iter().for_each(|key| frame[*key] = value.into()));
    }

    /// Changes the images of some frames.
    pub(crate) fn images(
        &self,
        which: impl IntoIterator<Item = usize>,
        change: impl Fn(RgbaImage) -> RgbaImage,
    ) {
        for i in which {
            let image = image_file::open(self.file(i)).unwrap().into_rgba8();
            change(image).save(self.file(i)).unwrap();
        }
    }

    /// Gives each frame a mask, made from its image.
    pub(crate) fn masks(&self, counts: impl Fn(usize, &[u8; 4]) -> bool) {
        self.frames(|i, frame| {
            let image = image_file::open(self.file(i)).unwrap().into_rgba8();
            let grey = |pixel: &image::Rgba<u8>| if counts(i, &pixel.0) { 255 } else { 0 };
            let mask = image::GrayImage::from_fn(image.width(), image.height(), |x, y| {
                image::Luma([grey(image.get_pixel(x, y))])
            });
            let name = format!("train/{i:03}.mask.png");
            mask.save(self.path().join(&name)).unwrap();
            frame["mask_path"] = name.into();
        });
    }

    /// Makes an image a JPEG file that is to be shown turned by a quarter.
    pub(crate) fn turned(&self, i: usize) {
        let image = image_file::open(self.file(i)).unwrap().into_rgb8();
        let mut jpeg = std::io::Cursor::new(Vec::new());
        image.write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
        let mut jpeg = jpeg.into_inner();
        // A segment of EXIF with one entry: orientation, a 16-bit number, 6.
        let mut exif = b"\xff\xe1\x00\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01".to_vec();
        exif.extend(b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0");
        jpeg.splice(2..2, exif);
        std::fs::write(self.file(i), jpeg).unwrap();
    }
}

fn pose(frame: &Value) -> Pose {
    serde_json::from_value(frame["transform_matrix"].clone()).unwrap()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &to),
            false => _ = std::fs::copy(entry.path(), to).unwrap(),
        }
    }
}

/// Columns two and three negated.
pub(crate) fn opencv(pose: Pose) -> Pose {
    pose.map(|[x, y, z, t]| [x, -y, -z, t])
}

/// The inverse of a rigid motion.
pub(crate) fn inverse(pose: Pose) -> Pose {
    let mut inverse = [[0.0; 4]; 4];
    for (i, row) in inverse.iter_mut().take(3).enumerate() {
        for (j, entry) in pose.iter().take(3).enumerate() {
            row[j] = entry[i];
            row[3] -= entry[i] * entry[3];
        }
    }
    inverse[3][3] = 1.0;
    inverse
}
