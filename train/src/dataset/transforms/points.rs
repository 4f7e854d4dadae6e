//! Points of the scene that nerfstudio names: `ply_file_path`, in the world of the poses.

use std::path::Path;

use crate::dataset::capture::{Around, around, points};
use crate::dataset::listing::{Frame, relative_path};
use crate::json::escape;

/// What the points say, and what to say of them.
pub(super) fn read(folder: &Path, path: &str, frames: &[Frame]) -> (Option<Around>, String) {
    let path = relative_path(path);
    let shown = escape(&path);
    let points = match points(&folder.join(&path)) {
        Ok(points) => points,
        Err(problem) => {
            return (None, format!("the points of {shown} are not used: {}", escape(&problem)));
        }
    };
    let found = around(&points, frames);
    let note = match &found {
        None => format!("too few points in {shown}: they are not used"),
        Some(Around { bounds: [near, far], .. }) => format!(
            "{} points of {shown}, at depths from {near:.3} to {far:.3}, say where the scene is",
            points.len()
        ),
    };
    (found, note)
}
