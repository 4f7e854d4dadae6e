//! Cameras that programs of photogrammetry export: Metashape's XML, RealityCapture's CSV.
//!
//! The photographs lie beside the file or in folders there. Coordinates may be those of a map,
//! far from the origin, so the world is moved and turned: the point that the cameras look at
//! becomes the origin, up +z, and the side that most cameras are on +x. Lengths stay.

mod calibration;
mod metashape;
mod photos;
mod reality_capture;
mod xml;

use std::path::{Path, PathBuf};

use super::capture::World;
use super::holdout::{HoldOut, kept};
use super::listing::{Frame, Listing};
use super::{DatasetError, LoadOptions, Split, images};
use crate::json;
use crate::pose;

/// Which program wrote the cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Program {
    Metashape,
    RealityCapture,
}

/// Cameras, before the world is moved.
struct Cameras {
    /// With a pose of its own each, which comes last.
    frames: Vec<Frame>,
    /// Camera-to-world, row after row, OpenGL camera axes.
    poses: Vec<[f64; 16]>,
    /// What is up; `None`: what cameras call so.
    up: Option<glam::DVec3>,
    notes: Vec<String>,
}

/// The program whose cameras a folder holds.
pub(super) fn program(folder: &Path) -> Option<Program> {
    let has = |program: &Program| !program.files(folder).is_empty();
    [Program::Metashape, Program::RealityCapture].into_iter().find(has)
}

/// Reads and checks the cameras of a split.
pub(super) fn list(
    program: Program,
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Listing, DatasetError> {
    let files = program.files(folder);
    let [file] = &files[..] else {
        let names: Vec<_> =
            files.iter().filter_map(|file| Some(file.file_name()?.to_string_lossy())).collect();
        return Err(DatasetError::Export {
            file: folder.to_owned(),
            problem: format!("several files of cameras: {}", names.join(", ")),
            hint: "keep one of them",
        });
    };
    let Cameras { mut frames, poses, up, mut notes } = match program {
        Program::Metashape => metashape::read(folder, file)?,
        Program::RealityCapture => reality_capture::read(folder, file)?,
    };
    let mut world = World::default();
    poses.iter().for_each(|pose| world.push(pose, 0.0));
    match up {
        Some(up) => world.stand_along(up),
        None => world.stand_up(),
    }
    notes.push("the world is moved and turned, not scaled: cameras look at the origin".to_owned());
    for (index, (frame, pose)) in frames.iter_mut().zip(world.poses()).enumerate() {
        let (file, name) = (file.clone(), frame.path.clone());
        let wrong = |problem| DatasetError::Pose { file, frame: index, name, problem };
        frame.pose = pose::from_list(&pose).map_err(wrong)?;
    }
    let frames = kept(frames, split, HoldOut { file, every: options.hold_every })?;
    let sign = file.file_name().unwrap_or_default().display().to_string();
    let listing = Listing::new(program.format(), sign, file.clone(), frames);
    Ok(Listing { is_one_set: true, own: world.own(), notes, ..listing })
}

impl Program {
    /// The convention's name in reports.
    fn format(self) -> &'static str {
        match self {
            Self::Metashape => "metashape",
            Self::RealityCapture => "reality-capture",
        }
    }

    /// The files in a folder that are its cameras.
    fn files(self, folder: &Path) -> Vec<PathBuf> {
        let (ending, is_own): (_, fn(&str) -> bool) = match self {
            Self::Metashape => ("xml", metashape::is_own),
            Self::RealityCapture => ("csv", reality_capture::is_own),
        };
        let names = images::names(folder, &[ending]).unwrap_or_default();
        let files = names.iter().map(|name| folder.join(name));
        files.filter(|file| is_own(&begin(file))).collect()
    }
}

/// The first characters of a file.
fn begin(file: &Path) -> String {
    use std::io::Read as _;
    const SHOWN: u64 = 4096;
    let mut bytes = Vec::new();
    let read = std::fs::File::open(file).map(|file| file.take(SHOWN).read_to_end(&mut bytes));
    if read.is_err() {
        bytes.clear();
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A file as text.
fn text(file: &Path, hint: &'static str) -> Result<String, DatasetError> {
    let bytes = json::read(file)?;
    String::from_utf8(bytes).map_err(|_| DatasetError::Export {
        file: file.to_owned(),
        problem: "no text, expected UTF-8".to_owned(),
        hint,
    })
}

/// What to say of cameras that have no photograph: refused where most have none.
fn missing(
    file: &Path,
    missing: &[String],
    total: usize,
    notes: &mut Vec<String>,
) -> Result<(), DatasetError> {
    let Some(first) = missing.first() else { return Ok(()) };
    if 2 * missing.len() > total {
        return Err(DatasetError::Export {
            file: file.to_owned(),
            problem: format!(
                "{} of its {total} cameras have no photograph (first: {first})",
                missing.len()
            ),
            hint: "put the photographs beside it, or into images there",
        });
    }
    notes.push(format!(
        "{} of {total} cameras have no photograph (first: {}): they are left out",
        missing.len(),
        json::escape(first)
    ));
    Ok(())
}
