//! From a listing to views: finds, decodes and checks images and masks.

use std::path::Path;
use std::time::Instant;

use pocketnerf_core::Camera;
use rayon::prelude::*;

use super::images::{self, Image};
use super::listing::{Frame, Listing, Mask};
use super::turn::{Found, Turn, upright};
use super::{DatasetError, LoadOptions, View, memory};

/// A dataset is refused where more than one image in so many is unreadable.
const TOO_MANY: usize = 10;

/// Decodes and downscales the images of a listing; what the user should know of them. A few that
/// are unreadable are left out.
pub(super) fn views(
    listing: &Listing,
    options: &LoadOptions,
) -> Result<(Vec<View>, Vec<String>), DatasetError> {
    let folder = &listing.folder;
    let LoadOptions { downscale_factor: factor, deadline, memory: free, .. } = *options;
    let names = find_all(listing)?;
    if let Some(free) = free {
        memory::check(folder, &names, factor, free)?;
    }
    let in_time = || deadline.is_none_or(|deadline| Instant::now() < deadline);
    let decoded: Vec<_> = names
        .par_iter()
        .zip(&listing.frames)
        .map(|(name, frame)| in_time().then(|| decode(folder, name, frame, factor)))
        .collect();
    let (read, total) = (decoded.iter().flatten().count(), names.len());
    if read < total {
        return Err(DatasetError::OutOfTime { folder: folder.clone(), read, total });
    }
    let decoded = decoded.into_iter().flatten();
    let (mut views, mut unreadable) = (Vec::with_capacity(total), Vec::new());
    let mut first: Option<([u32; 2], String)> = None;
    let mut found = Found::default();
    for ((name, frame), decoded) in names.into_iter().zip(&listing.frames).zip(decoded) {
        // The first error in the dataset's order, whichever came first in time.
        let Decoded { size, image, mask, turn, was_linear } = match decoded {
            Err(error @ DatasetError::UnreadableImage { .. }) => {
                unreadable.push(error);
                continue;
            }
            decoded => decoded?,
        };
        found.add(turn, was_linear, &name);
        let (first_size, first) = first.get_or_insert_with(|| (size, name.clone()));
        if frame.intrinsics.shared && size != *first_size {
            return Err(DatasetError::ImageSize {
                image: folder.join(name),
                size,
                first: folder.join(first),
                first_size: *first_size,
            });
        }
        let camera = camera(folder, &name, frame, size)?.downscaled(factor);
        let mask = without_edges(mask, &camera, frame.edge);
        let mask = without_blind(mask, &camera, frame);
        if mask.as_ref().is_some_and(|mask| mask.iter().all(|counts| *counts == 0)) {
            return Err(DatasetError::NothingCounts { image: folder.join(name) });
        }
        views.push(View { lens: frame.lens, mask, ..View::new(name, camera, image.rgba) });
    }
    let mut notes = found.notes();
    let count = unreadable.len();
    match unreadable.into_iter().next() {
        None => {}
        Some(error) if count * TOO_MANY > total => return Err(error),
        Some(error) => notes.push(format!("{error}; {count} of {total} images are left out")),
    }
    Ok((views, notes))
}

/// The camera of a frame's image at its full size.
pub(super) fn camera(
    folder: &Path,
    name: &str,
    frame: &Frame,
    size: [u32; 2],
) -> Result<Camera, DatasetError> {
    frame.intrinsics.camera(size, frame.pose).ok_or_else(|| DatasetError::Shape {
        image: folder.join(name),
        size,
        expected: frame.intrinsics.size.unwrap_or_default(),
    })
}

/// The names of all images.
fn find_all(listing: &Listing) -> Result<Vec<String>, DatasetError> {
    let folder = &listing.folder;
    let find = |frame: &Frame| images::find(folder, &frame.path);
    let found: Vec<_> = listing.frames.iter().map(find).collect();
    if let Some(first) = found.iter().position(Option::is_none) {
        return Err(DatasetError::MissingImage {
            image: folder.join(&listing.frames[first].path),
            file: listing.file.clone(),
            missing: found.iter().filter(|name| name.is_none()).count(),
            total: found.len(),
        });
    }
    Ok(found.into_iter().flatten().collect())
}

/// A frame's image and mask, made smaller.
struct Decoded {
    /// Before it was made smaller.
    size: [u32; 2],
    image: Image,
    mask: Option<Vec<u8>>,
    turn: Turn,
    /// Whether its colours were linear.
    was_linear: bool,
}

fn decode(folder: &Path, name: &str, frame: &Frame, factor: u32) -> Result<Decoded, DatasetError> {
    let stored = images::read(&folder.join(name))?;
    let was_linear = stored.was_linear;
    let (mut image, turn) = upright(stored, frame);
    let size = image.size;
    let same_size = |path: &Path, other: &Image| match other.size == size {
        true => Ok(()),
        false => Err(DatasetError::MaskSize {
            mask: path.to_owned(),
            size: other.size,
            image: folder.join(name),
            image_size: size,
        }),
    };
    if let Some(path) = &frame.alpha {
        let path = folder.join(path);
        let alpha = images::decode(&path)?;
        same_size(&path, &alpha)?;
        let (to, from) = (image.rgba.iter_mut().skip(3), alpha.rgba.iter());
        to.step_by(4).zip(from.step_by(4)).for_each(|(to, from)| *to = *from);
    }
    let mask = match &frame.mask {
        None => None,
        Some(Mask { path, black_counts, may_be_larger }) => {
            let path = folder.join(path);
            let mask = images::decode(&path)?;
            if !(*may_be_larger && is_larger(mask.size, size)) {
                same_size(&path, &mask)?;
            }
            let counts = |[r, g, b, _]: &[u8; 4]| {
                let is_black = (r | g | b) == 0;
                if is_black == *black_counts { 255 } else { 0 }
            };
            let counts: Vec<u8> = mask.rgba.as_chunks().0.iter().map(counts).collect();
            let smaller = size.map(|side| side / factor.max(1));
            Some(images::downscaled_mask(mask.size, &counts, smaller))
        }
    };
    Ok(Decoded { size, image: image.downscaled(factor)?, mask, turn, was_linear })
}

/// Whether one size is a larger one of the same shape; a side may be rounded by a pixel.
fn is_larger(size: [u32; 2], than: [u32; 2]) -> bool {
    let ([w, h], [x, y]) = (size.map(u64::from), than.map(u64::from));
    w > x && h > y && (w * y).abs_diff(h * x) <= w.max(h)
}

/// The mask without a part of the width along each edge.
fn without_edges(mask: Option<Vec<u8>>, camera: &Camera, part: f64) -> Option<Vec<u8>> {
    let [width, height] = [camera.width, camera.height];
    let edge = (part * f64::from(width)).round() as u32;
    if edge == 0 {
        return mask;
    }
    let mut mask = mask.unwrap_or_else(|| vec![255; width as usize * height as usize]);
    let is_inside = |v: u32, side: u32| (edge..side.saturating_sub(edge)).contains(&v);
    for (y, row) in (0..).zip(mask.chunks_exact_mut(width as usize)) {
        for (x, counts) in (0..).zip(row) {
            *counts = if is_inside(x, width) && is_inside(y, height) { *counts } else { 0 };
        }
    }
    Some(mask)
}

/// The mask without pixels at which the lens shows nothing.
fn without_blind(mask: Option<Vec<u8>>, camera: &Camera, frame: &Frame) -> Option<Vec<u8>> {
    let [width, height] = [camera.width, camera.height];
    let shows = |x: u32, y: u32| frame.lens.shows(camera, x as f32 + 0.5, y as f32 + 0.5);
    let corners = [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)];
    // What lies farthest out is in the corners.
    if corners.into_iter().all(|(x, y)| shows(x, y)) {
        return mask;
    }
    let mut mask = mask.unwrap_or_else(|| vec![255; width as usize * height as usize]);
    for (y, row) in (0..).zip(mask.chunks_exact_mut(width as usize)) {
        for (x, counts) in (0..).zip(row) {
            *counts = if shows(x, y) { *counts } else { 0 };
        }
    }
    Some(mask)
}
