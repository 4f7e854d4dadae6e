//! RealityCapture and RealityScan: Export > Registration > Internal/External camera parameters,
//! as comma-separated values with a line of names.
//!
//! As nerfstudio reads it (`process_data/realitycapture_utils.py`): the camera-to-world rotation
//! is Rz(-heading) Rx(pitch) Ry(roll), in degrees, with OpenGL camera axes in a world whose z
//! (`alt`) is up: without any of them the camera looks down with north, +y, at its top. `f` is in
//! millimetres of a film 36 wide, along the longer side; `px` and `py` are parts of that side from
//! the middle. k1 to k4, t1 and t2 are OpenCV's k1 to k4, p1 and p2.

use std::path::Path;

use glam::{DMat3, DMat4, DVec3};

use super::photos::Photos;
use super::{Cameras, missing, text};
use crate::dataset::intrinsics::Intrinsics;
use crate::dataset::listing::Frame;
use crate::dataset::{DatasetError, images};
use crate::json::escape;
use crate::lens::Lens;

const HINT: &str = "export Registration from RealityCapture as \"Internal/External camera parameters\", in a local \
     coordinate system";
/// Columns that must be there, and those that may be.
const NEEDED: [&str; 8] = ["name", "x", "y", "alt", "heading", "pitch", "roll", "f"];
const OTHERS: [&str; 8] = ["px", "py", "k1", "k2", "k3", "k4", "t1", "t2"];
/// Width of the film that focal lengths are given for.
const FILM: f64 = 36.0;

/// Whether a text that begins so is a file of cameras.
pub(super) fn is_own(begin: &str) -> bool {
    let line = begin.trim_start_matches('\u{feff}').lines().find(|line| !line.trim().is_empty());
    let names = names(line.unwrap_or_default());
    ["name", "heading", "pitch", "roll"].iter().all(|name| names.iter().any(|own| own == name))
}

fn names(line: &str) -> Vec<String> {
    let names = line.split([',', ';']).map(|name| unquoted(name).trim_start_matches('#'));
    names.map(str::to_lowercase).collect()
}

fn unquoted(word: &str) -> &str {
    word.trim().trim_matches('"')
}

/// A line's numbers, in the order of the columns above without the name.
type Row = [f64; NEEDED.len() - 1 + OTHERS.len()];

pub(super) fn read(folder: &Path, file: &Path) -> Result<Cameras, DatasetError> {
    let refuse = |problem| DatasetError::Export { file: file.to_owned(), problem, hint: HINT };
    let text = text(file, HINT)?;
    let mut rows = rows(&text).map_err(refuse)?;
    rows.sort_by(|a, b| a.0.cmp(b.0));
    if let Some(pair) = rows.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(refuse(format!("{} is there twice, expected once", pair[0].0)));
    }
    let photos = Photos::new(folder);
    let (mut frames, mut poses, mut absent) = (Vec::new(), Vec::new(), Vec::new());
    for (name, row) in &rows {
        let Some(path) = photos.find(name).map_err(refuse)? else {
            absent.push((*name).to_owned());
            continue;
        };
        let wrong = |problem| refuse(format!("{name}: {problem}"));
        frames.push(frame(row, path, images::size(&folder.join(path))).map_err(wrong)?);
        poses.push(pose(row));
    }
    let mut notes = Vec::new();
    missing(file, &absent, rows.len(), &mut notes)?;
    notes.extend(on_the_globe(&rows));
    Ok(Cameras { frames, poses, up: Some(DVec3::Z), notes })
}

/// Names and numbers of all lines.
fn rows(text: &str) -> Result<Vec<(&str, Row)>, String> {
    let mut lines = text.lines().zip(1..).filter(|(line, _)| !line.trim().is_empty());
    let (first, _) = lines.next().ok_or("the file is empty")?;
    if first.contains(';') {
        return Err("columns between semicolons, expected commas".to_owned());
    }
    let names = names(first);
    let place = |name: &str| names.iter().position(|own| own == name);
    if let Some(name) = NEEDED.iter().find(|name| place(name).is_none()) {
        return Err(format!("no column {name}, expected {}", NEEDED.join(", ")));
    }
    let columns = NEEDED[1..].iter().chain(&OTHERS).map(|name| (*name, place(name)));
    let columns: Vec<(&str, Option<usize>)> = columns.collect();
    let name_at = place(NEEDED[0]).unwrap_or(0);
    let mut rows = Vec::new();
    for (line, place) in lines {
        let words: Vec<&str> = line.split(',').map(unquoted).collect();
        if words.len() != names.len() {
            let (found, expected) = (words.len(), names.len());
            return Err(format!("line {place}: {found} values, expected {expected}"));
        }
        let mut row: Row = [0.0; 15];
        for (number, (column, at)) in row.iter_mut().zip(&columns) {
            let Some(at) = at else { continue };
            let word = words[*at];
            *number =
                word.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| {
                    let shown: String = word.chars().take(40).collect();
                    format!("line {place}: {column} is \"{}\", expected a number", escape(&shown))
                })?;
        }
        rows.push((words[name_at], row));
    }
    if rows.is_empty() {
        return Err("no camera, expected a line for each".to_owned());
    }
    Ok(rows)
}

/// Camera-to-world, row after row.
fn pose(&[x, y, alt, heading, pitch, roll, ..]: &Row) -> [f64; 16] {
    let rotation = DMat3::from_rotation_z(-heading.to_radians())
        * DMat3::from_rotation_x(pitch.to_radians())
        * DMat3::from_rotation_y(roll.to_radians());
    let mut pose = DMat4::from_mat3(rotation);
    pose.w_axis = DVec3::new(x, y, alt).extend(1.0);
    pose.transpose().to_cols_array()
}

/// An image without a size cannot be read, which is said when it is decoded.
fn frame(row: &Row, path: &str, size: Option<[u32; 2]>) -> Result<Frame, String> {
    let [.., f, px, py, k1, k2, k3, k4, t1, t2] = *row;
    let [width, height] = size.unwrap_or([1; 2]).map(f64::from);
    let longer = width.max(height);
    let focal = f / FILM * longer;
    let center = [0.5 * width + px * longer, 0.5 * height + py * longer];
    let lens = Lens::open_cv([k1, k2, k3, k4], [t1, t2]);
    let pixels = [focal, focal, center[0], center[1]];
    // Parts of the image's own size: that tells nothing of how the image is turned.
    let intrinsics =
        Intrinsics { size: None, ..Intrinsics::from_pixels([width, height], pixels, &lens)? };
    Ok(Frame::new(path.to_owned(), [0.0; 16], intrinsics, lens))
}

/// What to say of positions that look like degrees: heights differ by far more.
fn on_the_globe(rows: &[(&str, Row)]) -> Option<String> {
    let spread = |axis: usize| {
        let values = || rows.iter().map(|(_, row)| row[axis]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    let is_tiny = spread(0).max(spread(1)) < 1e-2 && spread(2) > 100.0 * spread(0).max(spread(1));
    (rows.len() > 2 && is_tiny).then(|| {
        "x and y differ by little, alt by much: are they degrees? Export in metres then".to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Right, up and back of a camera.
    fn axes(heading: f64, pitch: f64, roll: f64) -> [[f64; 3]; 3] {
        let row = [0.0, 0.0, 0.0, heading, pitch, roll, 18., 0., 0., 0., 0., 0., 0., 0., 0.];
        let m = pose(&row);
        // Adding 0 makes -0 of it.
        [0, 1, 2].map(|c| [m[c], m[4 + c], m[8 + c]].map(|v| v.round() + 0.0))
    }

    #[test]
    fn angles_by_hand() {
        // Down, north at the top; east at the top, so that south is right.
        assert_eq!(axes(0., 0., 0.), [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]);
        assert_eq!(axes(90., 0., 0.), [[0., -1., 0.], [1., 0., 0.], [0., 0., 1.]]);
        // Tilted up to look north; banked so that right is down, looking west.
        assert_eq!(axes(0., 90., 0.), [[1., 0., 0.], [0., 0., 1.], [0., -1., 0.]]);
        assert_eq!(axes(0., 0., 90.), [[0., 0., -1.], [0., 1., 0.], [1., 0., 0.]]);
    }
}
