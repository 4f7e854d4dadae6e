//! LLFF captures: `poses_bounds.npy` beside `images` or `images_K`.
//!
//! 17 numbers an image, in the order of the images' names: a 3×5 matrix row after row,
//! whose columns are the camera's axes (down, right, back), its position, and height,
//! width and focal length in pixels of the full image; then the nearest and the farthest
//! depth. As in the released code of LLFF, the world is scaled so that the nearest depth
//! of all lies at 4/3, and turned so that the average camera is at the origin and looks
//! along −z.

use std::path::Path;

use super::capture::{World, choose};
use super::holdout::{HoldOut, kept};
use super::intrinsics::{Focal, Intrinsics};
use super::listing::{Frame, Listing};
use super::{DatasetError, LoadOptions, Split, images, npy};
use crate::lens::Lens;
use crate::pose;

/// The convention's name in reports.
const FORMAT: &str = "llff";
/// The file it is known by.
pub(super) const FILE: &str = "poses_bounds.npy";
/// Numbers an image.
const COLUMNS: usize = 17;

/// Reads and checks the poses of a split; looks at no image.
pub(super) fn list(
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Listing, DatasetError> {
    let file = folder.join(FILE);
    let matrix = npy::read(&file)?;
    let refuse = |problem| {
        let expected = npy::EXPECTED;
        Err(DatasetError::Contents { file: file.clone(), problem, expected })
    };
    if matrix.columns != COLUMNS {
        return refuse(format!("rows of {} numbers, expected 17", matrix.columns));
    }
    let rows = matrix.values.as_chunks::<COLUMNS>().0;
    if rows.is_empty() {
        return refuse("0 rows".to_owned());
    }
    let images = choose(folder, options.downscale_factor)?;
    let names = images::names(&folder.join(&images.folder), &images::EXTENSIONS)?;
    if names.len() != rows.len() {
        return Err(DatasetError::Count {
            folder: folder.join(&images.folder),
            images: names.len(),
            file,
            poses: rows.len(),
        });
    }
    let mut frames = Vec::with_capacity(rows.len());
    let mut world = World::default();
    for (index, (row, name)) in rows.iter().zip(&names).enumerate() {
        let path = format!("{}/{name}", images.folder);
        let at = |i: usize| row[i];
        // Right, up, back.
        let row_of = |r: usize| [at(5 * r + 1), -at(5 * r), at(5 * r + 2), at(5 * r + 3)];
        let pose = [row_of(0), row_of(1), row_of(2), [0.0, 0.0, 0.0, 1.0]].concat();
        if let Err(problem) = pose::from_list(&pose) {
            return Err(DatasetError::Pose { file, frame: index, name: path, problem });
        }
        let ([height, width, focal], [near, far]) = ([at(4), at(9), at(14)], [at(15), at(16)]);
        let sides = [height, width].iter().all(|side| (1.0..1e6).contains(side));
        if !(sides && (1e-3..1e7).contains(&focal)) {
            let problem =
                format!("height {height}, width {width} and focal length {focal}, expected pixels");
            return Err(DatasetError::Camera { file, frame: index, name: path, problem });
        }
        if !(near > 0.0 && near < far && far < 1e30) {
            let problem = format!(
                "depths from {near} to {far}, expected two positive numbers, the nearest first"
            );
            return Err(DatasetError::Camera { file, frame: index, name: path, problem });
        }
        let half_angle = (0.5 * width.hypot(height) / focal).atan();
        world.push(&pose, half_angle);
        world.see([near, far]);
        let pixels = Some(Focal::Pixels(focal));
        let intrinsics = Intrinsics {
            size: Some([width, height]),
            focal: [pixels; 2],
            center: [None; 2],
            shared: true,
        };
        // The pose follows when the world has been turned.
        frames.push(Frame::new(path, [0.0; 16], intrinsics, Lens::Pinhole));
    }
    world.recentre();
    let looks_around = world.looks_around();
    let mut notes = images.notes;
    if options.spherify {
        if !world.spherify() {
            return Err(DatasetError::NoMiddle(file));
        }
    } else if looks_around {
        notes.push(
            "the cameras look around, not forward (normalised device coordinates do not suit them); \
             --spherify centres a 360-degree capture"
                .to_owned(),
        );
    }
    for (index, (frame, pose)) in frames.iter_mut().zip(world.poses()).enumerate() {
        frame.pose = match pose::from_list(&pose) {
            Ok(pose) => pose,
            Err(problem) => {
                let name = frame.path.clone();
                return Err(DatasetError::Pose { file, frame: index, name, problem });
            }
        };
    }
    let frames = kept(frames, split, HoldOut { file: &file, every: options.hold_every })?;
    Ok(Listing {
        is_one_set: true,
        factor: Some(images.factor),
        bounds: Some(world.bounds()),
        forward_facing: !looks_around && !options.spherify,
        own: world.own(),
        notes,
        ..Listing::new(FORMAT, FILE.to_owned(), file, frames)
    })
}
