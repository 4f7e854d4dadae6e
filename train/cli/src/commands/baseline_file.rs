//! Files of baselines.

use std::path::Path;

use pocketnerf_baselines::{Baseline, Origin, is_baseline};
use pocketnerf_core::Camera;
use pocketnerf_formats::{About, PhotographList, Scene};

use super::Failure;
use super::train::default_camera;

/// Opens a baseline's bytes; the error names the file.
pub(super) fn open_baseline(path: &Path, bytes: &[u8]) -> Result<Baseline, Failure> {
    Baseline::from_bytes(bytes).map_err(|e| format!("{}: {e}", path.display()).into())
}

/// Refuses the file of a baseline where a model is needed.
pub(super) fn refuse_baseline(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    match is_baseline(bytes) {
        true => Err(format!(
            "{}: this is a baseline, expected a model; baselines are for eval, render, info and chart",
            path.display()
        )
        .into()),
        false => Ok(()),
    }
}

/// The cameras of a baseline's photographs.
pub(super) fn photographs(origin: &Origin) -> Option<PhotographList> {
    let camera = |camera_to_world: &[f32; 16]| Camera {
        camera_to_world: *camera_to_world,
        ..origin.camera()
    };
    PhotographList::new(&origin.poses.iter().map(camera).collect::<Vec<_>>())
}

/// What a model's file says of its scene, of a baseline.
pub(super) fn about<'a>(origin: &Origin, photographs: Option<&'a PhotographList>) -> About<'a> {
    let (scale, rotation, translation) = origin.to_dataset;
    About {
        camera: Some(default_camera(&origin.camera())),
        photographs: photographs.map(PhotographList::view),
        scene: Scene { scale, rotation, translation, name: None },
        ..About::default()
    }
}
