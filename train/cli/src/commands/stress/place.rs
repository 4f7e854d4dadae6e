//! Where photographs and model of a training lie.

use std::path::{Path, PathBuf};

use super::scene::SpoiltScene;
use crate::commands::reading::BUILT_IN;
use crate::stress::{Photos, Training};

/// Where photographs and model of a training lie.
pub(super) struct Place {
    /// As on a command line.
    pub(super) data: PathBuf,
    /// The folder, where it is written here.
    pub(super) written: Option<PathBuf>,
    pub(super) model: PathBuf,
    /// Options of commands that read the data.
    pub(super) options: Vec<String>,
    /// What is changed in photographs and truth.
    pub(super) all: Option<crate::stress::Change>,
}

impl Place {
    pub(super) fn new(folder: &Path, scene: &SpoiltScene, training: &Training) -> Self {
        let id = training.id();
        let model = folder.join(format!("{id}.pnerf"));
        let factor = ["--downscale-factor".to_owned(), scene.factor.to_string()];
        let given = scene.reading.given();
        let mut options: Vec<String> = factor.into();
        let (data, written) = match training.photos {
            Photos::Written => {
                options.clear();
                let folder = folder.join("data").join(&id);
                (folder.clone(), Some(folder))
            }
            Photos::Given => {
                options.extend(given.split_whitespace().map(str::to_owned));
                (scene.data.clone(), None)
            }
            Photos::BuiltIn(name) => (PathBuf::from(format!("{BUILT_IN}:{name}")), None),
        };
        Self { data, written, model, options, all: training.all }
    }
}
