//! A COLMAP model: its files, and what is in them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{DMat4, DQuat, DVec3};

use super::camera::Camera;
use super::{binary, text};
use crate::dataset::DatasetError;
use crate::json::escape;
use crate::pose;

/// Longer files are not read.
const LONGEST: u64 = 2 << 30;
/// A point that fewer images show is often none.
const SEEN: usize = 3;
/// What to do about an unknown camera.
pub(super) const CAMERA_HINT: &str = "undistort the images with COLMAP's image_undistorter first";

/// Cameras, images and points.
pub(super) struct Model {
    pub(super) cameras: HashMap<u32, Camera>,
    /// In the order of their names.
    pub(super) images: Vec<Image>,
    /// Those that at least three images show.
    pub(super) points: Vec<Point>,
    /// The file of images.
    pub(super) file: PathBuf,
}

/// A registered image.
pub(super) struct Image {
    pub(super) id: u32,
    pub(super) name: String,
    pub(super) camera: u32,
    /// Camera-to-world, OpenGL camera axes.
    pub(super) pose: DMat4,
}

/// A point of the scene, and the images that show it.
pub(super) struct Point {
    pub(super) at: DVec3,
    pub(super) images: Vec<u32>,
}

/// A file, read.
pub(super) struct File<'f> {
    pub(super) path: &'f Path,
    pub(super) bytes: &'f [u8],
}

/// How the files of a model are written: binary, or else as text.
#[derive(Clone, Copy)]
enum Form {
    Binary,
    Text,
}

/// Whether a folder holds a model.
pub(super) fn is_model(folder: &Path) -> bool {
    form(folder).is_some()
}

/// How many images a model says it has.
pub(super) fn count_images(folder: &Path) -> Result<usize, DatasetError> {
    let form = form(folder).unwrap_or(Form::Binary);
    parse(form, folder, "images", binary::announced, text::listed).map(|(count, _)| count)
}

fn form(folder: &Path) -> Option<Form> {
    let has =
        |form: &Form| ["cameras", "images"].iter().any(|name| form.path(folder, name).is_file());
    [Form::Binary, Form::Text].into_iter().find(has)
}

impl Form {
    fn path(self, folder: &Path, name: &str) -> PathBuf {
        folder.join(match self {
            Self::Binary => format!("{name}.bin"),
            Self::Text => format!("{name}.txt"),
        })
    }
}

/// Reads and checks a model. One without points is one of cameras alone.
pub(super) fn read_model(folder: &Path) -> Result<Model, DatasetError> {
    let form = form(folder).unwrap_or(Form::Binary);
    let (cameras, cameras_file) = parse(form, folder, "cameras", binary::cameras, text::cameras)?;
    let (mut images, file) = parse(form, folder, "images", binary::images, text::images)?;
    let points = match form.path(folder, "points3D").is_file() {
        true => parse(form, folder, "points3D", binary::points, text::points)?.0,
        false => Vec::new(),
    };
    images.sort_by(|a, b| a.name.cmp(&b.name));
    let wrong = |problem| Err(DatasetError::Colmap { file: file.clone(), problem });
    if images.is_empty() {
        return wrong("no image is registered, expected at least one".to_owned());
    }
    if let Some(pair) = images.windows(2).find(|pair| pair[0].name == pair[1].name) {
        return wrong(format!("the image {} is there twice, expected once", escape(&pair[0].name)));
    }
    let cameras: HashMap<u32, Camera> = cameras.into_iter().collect();
    if let Some(image) = images.iter().find(|image| !cameras.contains_key(&image.camera)) {
        return wrong(format!(
            "the image {} has camera {}, which {} does not list",
            escape(&image.name),
            image.camera,
            cameras_file.file_name().unwrap_or_default().display()
        ));
    }
    Ok(Model { cameras, images, points, file })
}

/// What is in a file of a model.
fn parse<T>(
    form: Form,
    folder: &Path,
    name: &str,
    binary: fn(&File<'_>) -> Result<T, DatasetError>,
    text: fn(&File<'_>) -> Result<T, DatasetError>,
) -> Result<(T, PathBuf), DatasetError> {
    let path = form.path(folder, name);
    let bytes = read(&path)?;
    let file = File { path: &path, bytes: &bytes };
    let parsed = match form {
        Form::Binary => binary(&file)?,
        Form::Text => text(&file)?,
    };
    Ok((parsed, path))
}

fn read(path: &Path) -> Result<Vec<u8>, DatasetError> {
    let wrong = |problem| DatasetError::Colmap { file: path.to_owned(), problem };
    let unreadable = |error: std::io::Error| wrong(format!("cannot be read: {error}"));
    let len = std::fs::metadata(path).map_err(unreadable)?.len();
    if len > LONGEST {
        return Err(wrong(format!("{len} bytes, at most {LONGEST} are read")));
    }
    std::fs::read(path).map_err(unreadable)
}

impl<'f> File<'f> {
    pub(super) fn wrong(&self, problem: String) -> DatasetError {
        DatasetError::Colmap { file: self.path.to_owned(), problem }
    }

    /// Bytes as text.
    pub(super) fn text(&self, bytes: &'f [u8]) -> Result<&'f str, DatasetError> {
        std::str::from_utf8(bytes)
            .map_err(|_| self.wrong("a text is no text, expected UTF-8".to_owned()))
    }
}

impl Image {
    /// `to_camera` turns and moves the world into the camera's axes: right, down, forward.
    pub(super) fn new(
        file: &File<'_>,
        id: u32,
        name: &str,
        camera: u32,
        to_camera: (DQuat, DVec3),
    ) -> Result<Self, DatasetError> {
        let (rotation, translation) = to_camera;
        if name.is_empty() {
            return Err(file.wrong("an image has no name, expected that of its file".to_owned()));
        }
        let wrong = |what| Err(file.wrong(format!("the image {}: {what}", escape(name))));
        let length = rotation.length();
        if !(1e-3..1e3).contains(&length) {
            return wrong(format!("a rotation of length {length}, expected 1"));
        }
        let to_world = rotation.normalize().conjugate();
        let position = -(to_world * translation);
        let axes = DMat4::from_rotation_translation(to_world, position);
        let pose = axes * DMat4::from_diagonal(glam::DVec4::new(1.0, -1.0, -1.0, 1.0));
        if let Err(problem) = pose::from_list(&pose.transpose().to_cols_array()) {
            return wrong(problem.to_string());
        }
        Ok(Self { id, name: name.to_owned(), camera, pose })
    }
}

impl Point {
    /// `None` where it is nowhere, or too few images show it.
    pub(super) fn new(at: DVec3, images: Vec<u32>) -> Option<Self> {
        (at.is_finite() && images.len() >= SEEN).then_some(Self { at, images })
    }
}
