//! DeepVoxels: `{train,validation,test}/SCENE/{rgb,pose,intrinsics.txt}`.
//!
//! A file of 16 numbers an image in `pose`: camera-to-world with OpenCV camera axes.
//! `intrinsics.txt`: focal length (and a principal point, which the released code
//! ignores: it is the middle), barycentre, near plane, scale, height and width that the
//! focal length is counted in, and perhaps 1 where poses are world-to-camera. The focal
//! length follows the image's height. Images are opaque, on white; the cameras are on a
//! hemisphere, and what they see lies within 1 of its middle.

use std::path::{Path, PathBuf};

use glam::DMat4;

use super::intrinsics::{Focal, Intrinsics};
use super::listing::{Frame, Listing};
use super::{DatasetError, Split, images};
use crate::lens::Lens;
use crate::pose;

/// The convention's name in reports.
const FORMAT: &str = "deepvoxels";
/// In the order of [`Split::ALL`].
const FOLDERS: [&str; 3] = ["train", "validation", "test"];
/// The file that marks a scene's folder.
const INTRINSICS: &str = "intrinsics.txt";
/// Completes "expected …".
const POSE: &str = "16 numbers an image, a camera-to-world matrix row after row (DeepVoxels)";
/// The scene reaches so far from the middle of the hemisphere.
const REACH: f64 = 1.0;

/// The folders of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Holds `train`, `validation`, `test`.
    pub(super) root: PathBuf,
    /// The scenes in them.
    pub(super) scenes: Vec<String>,
}

/// Where the scene of a folder lies: the folder may be the root, one of a split, or one
/// of a split's scene. `None`: nowhere.
pub(super) fn find(folder: &Path) -> Option<Place> {
    let is_scene = |path: &Path| path.join(INTRINSICS).is_file() && path.join("pose").is_dir();
    let scenes_of = |split: &Path| -> Vec<String> {
        let entries = std::fs::read_dir(split).into_iter().flatten().flatten();
        let scenes = entries.filter(|entry| is_scene(&entry.path()));
        scenes.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    };
    let is_split = |path: &Path| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        name.is_some_and(|name| FOLDERS.contains(&name.as_str()))
    };
    let folder = std::path::absolute(folder).ok()?;
    let parent = folder.parent();
    if is_scene(&folder) {
        let split = parent.filter(|parent| is_split(parent))?;
        let scene = folder.file_name()?.to_string_lossy().into_owned();
        return Some(Place { root: split.parent()?.to_owned(), scenes: vec![scene] });
    }
    let root = match is_split(&folder) && !scenes_of(&folder).is_empty() {
        true => parent?.to_owned(),
        false => folder,
    };
    let mut scenes: Vec<String> =
        FOLDERS.iter().flat_map(|split| scenes_of(&root.join(split))).collect();
    scenes.sort();
    scenes.dedup();
    (!scenes.is_empty()).then_some(Place { root, scenes })
}

/// Reads and checks the poses of a split; looks at no image.
pub(super) fn list(folder: &Path, split: Split) -> Result<Listing, DatasetError> {
    let missing = || DatasetError::Missing(folder.to_owned());
    let Place { root, scenes } = find(folder).ok_or_else(missing)?;
    let [scene] = &scenes[..] else {
        return Err(DatasetError::Scenes { folder: root, scenes: scenes.join(", ") });
    };
    let at = |split: &str| root.join(split).join(scene);
    let has: Vec<&str> = FOLDERS.into_iter().filter(|split| at(split).is_dir()).collect();
    let name = match split {
        Split::Train => "train",
        Split::Val if has.contains(&"validation") => "validation",
        Split::Val | Split::Test => "test",
    };
    if !has.contains(&name) {
        let (file, split) = (at(name), split.name());
        return Err(DatasetError::NoSplit { file, split, has: has.join(", ") });
    }
    let (file, frames) = frames(&root, &format!("{name}/{scene}"))?;
    // The hemisphere is that of the training cameras.
    let radius = match name == "train" || !has.contains(&"train") {
        true => radius(&frames),
        false => radius(&self::frames(&root, &format!("train/{scene}"))?.1),
    };
    let near = (radius - REACH).max(0.0);
    let listing = Listing::new(FORMAT, format!("{name}/{scene}/{INTRINSICS}"), file, frames);
    Ok(Listing {
        folder: root,
        bounds: Some([near as f32, (radius + REACH) as f32]),
        background: Some([1.0; 3]),
        ..listing
    })
}

/// The frames in a split's scene folder, and the folder of their poses.
fn frames(root: &Path, scene: &str) -> Result<(PathBuf, Vec<Frame>), DatasetError> {
    let folder = root.join(scene);
    let (intrinsics, inverse) = intrinsics(&folder.join(INTRINSICS))?;
    let poses = folder.join("pose");
    let names = images::names(&poses, &["txt"])?;
    let colors = folder.join("rgb");
    let found = images::names(&colors, &images::EXTENSIONS)?.len();
    if names.is_empty() {
        let (problem, expected) = ("no .txt file".to_owned(), POSE);
        return Err(DatasetError::Contents { file: poses, problem, expected });
    }
    if found != names.len() {
        let (images, count) = (found, names.len());
        return Err(DatasetError::Count { folder: colors, images, file: poses, poses: count });
    }
    let mut frames = Vec::with_capacity(names.len());
    for (index, name) in names.iter().enumerate() {
        let file = poses.join(name);
        let pose = DMat4::from_cols_array(&numbers(&file)?).transpose();
        let pose = if inverse { pose.inverse() } else { pose };
        // Right, down, forward to right, up, back.
        let pose = pose * DMat4::from_diagonal(glam::DVec4::new(1.0, -1.0, -1.0, 1.0));
        let pose = pose::from_list(&pose.transpose().to_cols_array()).map_err(|problem| {
            DatasetError::Pose { file: file.clone(), frame: index, name: name.clone(), problem }
        })?;
        let stem = name.trim_end_matches(".txt");
        let path = format!("{scene}/rgb/{stem}");
        frames.push(Frame::new(path, pose, intrinsics, Lens::Pinhole));
    }
    Ok((poses, frames))
}

/// The camera, and whether poses are world-to-camera.
fn intrinsics(file: &Path) -> Result<(Intrinsics, bool), DatasetError> {
    let text = read(file)?;
    let lines: Vec<Vec<f64>> = text.lines().map(parse).collect();
    let number = |line: usize, i: usize| lines.get(line).and_then(|l| l.get(i)).copied();
    let (focal, height, width) = (number(0, 0), number(4, 0), number(4, 1));
    let (Some(focal), Some(height), Some(_)) = (focal, height, width) else {
        return Err(contents(file, format!("{} lines without them", lines.len())));
    };
    if !((1e-3..1e7).contains(&focal) && (1.0..1e6).contains(&height)) {
        return Err(contents(file, format!("focal length {focal} and height {height}")));
    }
    let inverse = number(5, 0).is_some_and(|flag| flag != 0.0);
    let focal = [None, Some(Focal::Heights(focal / height))];
    Ok((Intrinsics { size: None, focal, center: [None; 2], shared: true }, inverse))
}

/// The numbers of a pose.
fn numbers(file: &Path) -> Result<[f64; 16], DatasetError> {
    let numbers = parse(&read(file)?);
    <[f64; 16]>::try_from(&numbers[..]).map_err(|_| {
        let problem = format!("{} numbers", numbers.len());
        DatasetError::Contents { file: file.to_owned(), problem, expected: POSE }
    })
}

/// The numbers of a text up to the first word that is none.
fn parse(text: &str) -> Vec<f64> {
    text.split_whitespace().map_while(|word| word.parse().ok()).collect()
}

fn read(file: &Path) -> Result<String, DatasetError> {
    std::fs::read_to_string(file).map_err(|error| contents(file, error.to_string()))
}

fn contents(file: &Path, problem: String) -> DatasetError {
    let expected = "a focal length in line 1 and height and width in line 5 (DeepVoxels)";
    DatasetError::Contents { file: file.to_owned(), problem, expected }
}

/// Mean distance of the cameras from the origin.
fn radius(frames: &[Frame]) -> f64 {
    let distance = |frame: &Frame| {
        [3, 7, 11].map(|i| f64::from(frame.pose[i])).iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    frames.iter().map(distance).sum::<f64>() / frames.len() as f64
}
