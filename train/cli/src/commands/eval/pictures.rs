//! Pictures of what is compared, side by side.

use std::path::{Path, PathBuf};

use pocketnerf_core::Camera;
use pocketnerf_train::evaluate::{ViewScore, worst};
use pocketnerf_train::output::write_atomic;
use pocketnerf_train::picture::image_file;

use crate::commands::{Failure, make_folder};

/// How many of the worst views' pictures are copied.
const WORST: usize = 3;

/// A folder of pictures, where one is wanted.
pub(super) struct Pictures {
    folder: Option<PathBuf>,
    failure: Option<Failure>,
}

impl Pictures {
    pub(super) fn new(folder: Option<&Path>) -> Result<Self, Failure> {
        Ok(Self { folder: folder.map(make_folder).transpose()?, failure: None })
    }

    /// Writes a view's rendering, image and difference.
    pub(super) fn add(&mut self, i: usize, camera: &Camera, rendering: &[u8], image: &[u8]) {
        let Some(folder) = &self.folder else { return };
        let path = folder.join(format!("{i:03}.png"));
        let difference = image_file::difference(rendering, image, 4);
        let (width, pixels) =
            image_file::side_by_side(camera.width, &[rendering, image, &difference]);
        let written = image_file::write_rgb(&path, width, camera.height, &pixels);
        if let Err(failure) = written {
            self.failure = Some(failure.into());
        }
    }

    /// Copies those of the worst views.
    pub(super) fn finish(self, per_view: &[ViewScore]) -> Result<(), Failure> {
        let Self { folder: Some(folder), failure } = self else { return Ok(()) };
        if let Some(failure) = failure {
            return Err(failure);
        }
        for (i, view) in worst(per_view).into_iter().take(WORST).enumerate() {
            let picture = folder.join(format!("{view:03}.png"));
            let bytes = std::fs::read(&picture)
                .map_err(|error| format!("{}: cannot be read: {error}", picture.display()))?;
            write_atomic(&folder.join(format!("worst-{}.png", i + 1)), &bytes)?;
        }
        Ok(())
    }
}
