//! The scenes of a chart.

use std::path::PathBuf;

use pocketnerf_train::dataset::{Dataset, Split};

use super::Chart;
use crate::commands::reading::{BUILT_IN, scene_name};
use crate::commands::{Common, Failure, Reading};

/// A dataset, how it is read, and which of its views are compared.
pub(super) struct Scene {
    /// Its name in the chart.
    pub(super) name: String,
    /// As on a command line.
    pub(super) data: PathBuf,
    pub(super) reading: Reading,
    split: Split,
    views: Option<usize>,
}

impl Chart {
    /// The scenes, checked to have the views.
    pub(super) fn scenes(&self, common: &Common) -> Result<Vec<Scene>, Failure> {
        let given =
            if self.data.is_empty() { vec![PathBuf::from(BUILT_IN)] } else { self.data.clone() };
        let mut scenes: Vec<Scene> = Vec::new();
        for data in given {
            let name = scene_name(&data);
            if let Some(other) = scenes.iter().find(|other| other.name == name) {
                return Err(format!(
                    "{} and {}: both are called {name}, expected datasets of different names; \
                     chart them one by one",
                    other.data.display(),
                    data.display()
                )
                .into());
            }
            let (reading, split, views) = (self.reading, self.split, self.n_views());
            let scene = Scene { name, data, reading, split, views };
            // Refused before hours of training.
            for factor in self.factors() {
                let dataset = scene.held_out(*factor)?;
                if !common.quiet {
                    dataset.notes.iter().for_each(|note| eprintln!("note: {note}"));
                }
            }
            scenes.push(scene);
        }
        Ok(scenes)
    }
}

impl Scene {
    /// The views that are compared.
    pub(super) fn held_out(&self, downscale_factor: u32) -> Result<Dataset, Failure> {
        let mut dataset = self.reading.read(&self.data, self.split, downscale_factor)?;
        if let Some(n) = self.views {
            dataset.thin(n);
        }
        if dataset.views.is_empty() {
            return Err(format!(
                "{}: no {} views, expected at least one; see --split and --hold-every",
                self.data.display(),
                self.split
            )
            .into());
        }
        Ok(dataset)
    }

    /// The images that models are trained on.
    pub(super) fn train_split(&self) -> Result<Dataset, Failure> {
        Ok(self.reading.read(&self.data, Split::Train, 1)?)
    }
}
