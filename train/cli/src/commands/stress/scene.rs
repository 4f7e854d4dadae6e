//! The scenes that are spoilt.

use std::path::PathBuf;

use pocketnerf_train::dataset::{Dataset, Split};

use super::Stress;
use crate::commands::reading::{BUILT_IN, scene_name};
use crate::commands::{Failure, Reading};

/// Views that a quick table compares.
const QUICK_VIEWS: usize = 8;

/// A scene.
pub(super) struct SpoiltScene {
    /// Its name.
    pub(super) name: String,
    /// As on a command line.
    pub(super) data: PathBuf,
    pub(super) reading: Reading,
    pub(super) factor: u32,
    /// Test views at most.
    views: Option<usize>,
}

impl Stress {
    /// The scenes.
    pub(super) fn scenes(&self) -> Result<Vec<SpoiltScene>, Failure> {
        let given =
            if self.data.is_empty() { vec![PathBuf::from(BUILT_IN)] } else { self.data.clone() };
        let scenes = given.into_iter().map(|data| {
            let built_in = data.to_string_lossy().starts_with(BUILT_IN) && !data.exists();
            let usual = if built_in || self.quick { 4 } else { 2 };
            let factor = self.downscale_factor.unwrap_or(usual);
            let name = scene_name(&data);
            SpoiltScene {
                name,
                data,
                reading: self.reading,
                factor,
                views: self.quick.then_some(QUICK_VIEWS),
            }
        });
        let scenes: Vec<SpoiltScene> = scenes.collect();
        for (i, scene) in scenes.iter().enumerate() {
            if scenes[..i].iter().any(|other| other.name == scene.name) {
                let name = &scene.name;
                return Err(
                    format!("{name}: given twice, expected scenes of different names").into()
                );
            }
        }
        Ok(scenes)
    }
}

impl SpoiltScene {
    /// A split, downscaled by a power of two more than usual.
    pub(super) fn load(&self, split: Split, smaller: i32) -> Result<Dataset, Failure> {
        let factor = if smaller < 0 { self.factor >> -smaller } else { self.factor << smaller };
        let mut dataset = self.reading.read(&self.data, split, factor.max(1))?;
        if let (Split::Test, Some(n)) = (split, self.views) {
            dataset.thin(n);
        }
        if dataset.views.is_empty() {
            let data = self.data.display();
            return Err(format!("{data}: no {split} views, expected at least one").into());
        }
        Ok(dataset)
    }

    /// Whether it is the still life that this program makes.
    pub(super) fn is_still_life(&self) -> bool {
        self.data.as_os_str() == BUILT_IN && !self.data.exists()
    }
}
