//! Why a dataset was refused: one line each, with the file, what was found,
//! what was expected and what to do.

use std::path::PathBuf;

use crate::json::{JsonError, escape, one_line};
use crate::pose::PoseProblem;

/// What can be read.
const CONVENTIONS: &str = "transforms_train.json (Blender), transforms.json (instant-ngp, nerfstudio), \
     poses_bounds.npy with images (LLFF), sparse/0 with images (COLMAP), train/SCENE/{rgb,pose,intrinsics.txt} (DeepVoxels), \
     or photographs with cameras of Metashape (.xml), RealityCapture (.csv), Polycam (keyframes), Record3D (metadata) or 3d Scanner App (frame_*.json)";

/// Who else finds cameras.
const OTHERS: &str =
    "as do colmap, ns-process-data of nerfstudio and colmap2nerf.py of instant-ngp";

/// Why a dataset was refused. Each message is one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// Nothing lies at the path.
    #[error("{}: no such folder; give the folder of a dataset: {CONVENTIONS}", one_line(.0))]
    Missing(PathBuf),
    /// The path is not a folder.
    #[error(
        "{}: this is a file, expected a dataset's folder; give the folder that holds it",
        one_line(.0)
    )]
    NotAFolder(PathBuf),
    /// A folder of so many photographs of which no cameras are known.
    #[error("{}: {} photographs without poses; `pocketnerf prepare` makes a dataset of them, {OTHERS}", one_line(.0), .1)]
    NoPoses(PathBuf, usize),
    /// A video.
    #[error("{}: a video; `pocketnerf prepare` makes a dataset of it, {OTHERS}", one_line(.0))]
    Video(PathBuf),
    /// An archive.
    #[error("{}: an archive, expected a folder; unpack it and give the folder", one_line(.0))]
    Archive(PathBuf),
    /// The folder cannot be listed.
    #[error("{}: cannot be listed: {source}; check its permissions", one_line(.folder))]
    Unlistable {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Nothing in the folder.
    #[error(
        "{}: the folder is empty; expected a dataset: {CONVENTIONS}",
        one_line(.0)
    )]
    Empty(PathBuf),
    /// No convention was recognised.
    #[error(
        "{}: no dataset recognised; found {}; expected {CONVENTIONS}{}",
        one_line(.folder), escape(.found),
        .inside.as_ref().map(|inner| format!("; \"{}\" inside it is one: give that folder", escape(inner))).unwrap_or_default()
    )]
    NotRecognised {
        /// The folder.
        folder: PathBuf,
        /// The first few names in it.
        found: String,
        /// A folder inside which holds a dataset.
        inside: Option<String>,
    },
    /// The dataset has no such split.
    #[error("{}: not there, so there is no {split} split; this dataset has {has}", one_line(.file))]
    NoSplit {
        /// The file that would hold the split.
        file: PathBuf,
        /// The split's name.
        split: &'static str,
        /// The splits that are there.
        has: String,
    },
    /// A JSON file is wrong.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// A JSON file without frames.
    #[error("{}: \"frames\" is empty, expected at least one frame; re-export the dataset", one_line(.0))]
    NoFrames(PathBuf),
    /// A JSON file without a field of view.
    #[error("{}: no \"camera_angle_x\"; expected the horizontal field of view in radians", one_line(.0))]
    NoFieldOfView(PathBuf),
    /// A field of view that no camera has.
    #[error(
        "{}: camera_angle_x is {angle}, expected radians from 0.01 to below pi{}",
        one_line(.file),
        if *.angle >= std::f64::consts::PI { "; degrees must be converted" } else { "" }
    )]
    FieldOfView {
        /// The file.
        file: PathBuf,
        /// What was found.
        angle: f64,
    },
    /// A pose is wrong.
    #[error("{}: frame {frame} (\"{}\"): {problem}", one_line(.file), escape(.name))]
    Pose {
        /// The JSON file.
        file: PathBuf,
        /// The frame's place in the list, from 0.
        frame: usize,
        /// The frame's `file_path`.
        name: String,
        /// What is wrong.
        problem: PoseProblem,
    },
    /// Images are missing.
    #[error(
        "{}: no such image (nor with .png, .jpg and the like added); {} lists {total} frames and {missing} of their images missing: \
         add the images or take the frames out of the list",
        one_line(.image), one_line(.file)
    )]
    MissingImage {
        /// The first image that is missing.
        image: PathBuf,
        /// The JSON file that lists it.
        file: PathBuf,
        /// How many images are missing.
        missing: usize,
        /// How many frames there are.
        total: usize,
    },
    /// An image cannot be decoded.
    #[error("{}: unreadable image: {}; expected a whole PNG, JPEG, WebP, TIFF or EXR file", one_line(.image), escape(.problem))]
    UnreadableImage {
        /// The image.
        image: PathBuf,
        /// The decoder's reason.
        problem: String,
    },
    /// There was no time to read all images.
    #[error("{}: only {read} of {total} images could be read in time; expected time for all and for training: give more seconds", one_line(.folder))]
    OutOfTime {
        /// The dataset's folder.
        folder: PathBuf,
        /// Images that were read.
        read: usize,
        /// Images that there are.
        total: usize,
    },
    /// An image has another size than the first one.
    #[error(
        "{}: {}x{} pixels, but {} has {}x{}; expected images of one size, since they share one camera",
        one_line(.image), .size[0], .size[1], one_line(.first), .first_size[0], .first_size[1]
    )]
    ImageSize {
        /// The image.
        image: PathBuf,
        /// Its width and height.
        size: [u32; 2],
        /// The first image.
        first: PathBuf,
        /// Its width and height.
        first_size: [u32; 2],
    },
    /// Images cannot be made smaller by this factor.
    #[error("downscale factor {factor}: expected 1 to {largest} for images of {}x{}", .size[0], .size[1])]
    DownscaleFactor {
        /// What was requested.
        factor: u32,
        /// The largest that leaves a pixel.
        largest: u32,
        /// The images' width and height.
        size: [u32; 2],
    },
    /// A camera is wrong.
    #[error("{}: frame {frame} (\"{}\"): {}", one_line(.file), escape(.name), escape(.problem))]
    Camera {
        /// The file that lists it.
        file: PathBuf,
        /// The frame's place in the list, from 0.
        frame: usize,
        /// The frame's image.
        name: String,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// Something that is known and cannot be read.
    #[error("{}: {} cannot be read; {hint}", one_line(.file), escape(.what))]
    NotReadable {
        /// The file.
        file: PathBuf,
        /// The key or value.
        what: String,
        /// What to do.
        hint: &'static str,
    },
    /// The scene's box is none.
    #[error("{}: \"{key}\" makes no box, expected {expected}", one_line(.file))]
    Box {
        /// The file.
        file: PathBuf,
        /// The key.
        key: &'static str,
        /// What it should be.
        expected: &'static str,
    },
    /// A split's list names a frame that is not there.
    #[error("{}: {list}_filenames lists \"{}\", which no frame has as its file_path; correct the list", one_line(.file), escape(.name))]
    NoSuchFrame {
        /// The file.
        file: PathBuf,
        /// The list's split.
        list: &'static str,
        /// The name in it.
        name: String,
    },
    /// No image is left for a split.
    #[error("{}: no {split} images: {why}", one_line(.file))]
    EmptySplit {
        /// The file that lists them.
        file: PathBuf,
        /// The split.
        split: &'static str,
        /// What the others are.
        why: String,
    },
    /// An image has another shape than its camera.
    #[error(
        "{}: {}x{} pixels, but its camera is for {}x{}; expected an image of that shape: correct w and h or the image",
        one_line(.image), .size[0], .size[1], .expected[0], .expected[1]
    )]
    Shape {
        /// The image.
        image: PathBuf,
        /// Its width and height.
        size: [u32; 2],
        /// The camera's.
        expected: [f64; 2],
    },
    /// A mask does not fit its image.
    #[error(
        "{}: {}x{} pixels, but {} has {}x{}; expected a mask of its image's size",
        one_line(.mask), .size[0], .size[1], one_line(.image), .image_size[0], .image_size[1]
    )]
    MaskSize {
        /// The mask, or the file of alpha.
        mask: PathBuf,
        /// Its width and height.
        size: [u32; 2],
        /// The image.
        image: PathBuf,
        /// Its width and height.
        image_size: [u32; 2],
    },
    /// A mask leaves nothing.
    #[error("{}: its mask or lens leaves no pixel to learn from; correct the mask or take the frame out of the list", one_line(.image))]
    NothingCounts {
        /// The image.
        image: PathBuf,
    },
    /// A file of numbers holds something else.
    #[error("{}: {}; expected {expected}", one_line(.file), escape(.problem))]
    Contents {
        /// The file.
        file: PathBuf,
        /// What was found.
        problem: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// A file of a COLMAP model is wrong.
    #[error("{}: {}; write the model again with COLMAP", one_line(.file), escape(.problem))]
    Colmap {
        /// The file.
        file: PathBuf,
        /// What was found, and what was expected.
        problem: String,
    },
    /// What another program has exported is wrong, or not all that is needed.
    #[error("{}: {}; {hint}", one_line(.file), escape(.problem))]
    Export {
        /// The file, or the folder.
        file: PathBuf,
        /// What was found, and what was expected.
        problem: String,
        /// What to export instead.
        hint: &'static str,
    },
    /// More than one scene.
    #[error("{}: several scenes: {}; give the folder of one, as train/SCENE", one_line(.folder), escape(.scenes))]
    Scenes {
        /// The folder.
        folder: PathBuf,
        /// Their names.
        scenes: String,
    },
    /// No built-in scene has this name.
    #[error("{}: no such built-in scene; expected one of {scenes}", one_line(.path))]
    NoSuchScene {
        /// What was given.
        path: PathBuf,
        /// The names that there are.
        scenes: String,
    },
    /// A capture without images.
    #[error("{}: no folder of images; expected images, or images_4 and the like, in this folder", one_line(.0))]
    NoImageFolder(PathBuf),
    /// Images and poses differ in number.
    #[error(
        "{}: {images} images, but {} has {poses} poses; expected one each, in the order of the names: \
         remove the images that have no pose",
        one_line(.folder), one_line(.file)
    )]
    Count {
        /// The folder of images.
        folder: PathBuf,
        /// PNG and JPEG files in it.
        images: usize,
        /// The file of poses.
        file: PathBuf,
        /// How many.
        poses: usize,
    },
    /// The images do not fit into memory.
    #[error(
        "{}: {images} images of up to {}x{} pixels need {:.1} GB of memory, but {:.1} GB are free; \
         give {}",
        one_line(.folder), .largest[0], .largest[1], gigabytes(.needed), gigabytes(.free),
        .factor.map_or("fewer images".to_owned(), |n| format!("--downscale-factor {n} or more"))
    )]
    Memory {
        /// The dataset's folder.
        folder: PathBuf,
        /// How many.
        images: usize,
        /// Width and height of the largest.
        largest: [u32; 2],
        /// Bytes.
        needed: u64,
        /// Bytes.
        free: u64,
        /// The least factor with which they fit, if one does.
        factor: Option<u32>,
    },
    /// A capture around nothing.
    #[error("{}: --spherify needs cameras around a point, but these look in parallel; leave it out", one_line(.0))]
    NoMiddle(PathBuf),
    /// Only LLFF captures are made spheres.
    #[error("{}: --spherify is for LLFF captures (poses_bounds.npy), which this is not; leave it out", one_line(.0))]
    Spherify(PathBuf),
}

fn gigabytes(bytes: &u64) -> f64 {
    *bytes as f64 / 1e9
}
