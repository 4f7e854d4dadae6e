//! Smaller views.

use super::View;
use crate::dataset::images::{Image, downscaled_mask};
use crate::dataset::{Dataset, DatasetError};

impl Dataset {
    /// With images `factor` times smaller along each side, as [`load`](crate::dataset::load) makes
    /// them; known depths are left out, as they have no mean.
    ///
    /// # Errors
    /// [`DatasetError::DownscaleFactor`] if nothing would be left of an image.
    pub fn downscaled(mut self, factor: u32) -> Result<Self, DatasetError> {
        if factor == 1 {
            return Ok(self);
        }
        let views = self.views.into_iter().map(|view| view.downscaled(factor));
        self.views = views.collect::<Result<_, _>>()?;
        Ok(self)
    }
}

impl View {
    fn downscaled(self, factor: u32) -> Result<Self, DatasetError> {
        let size = [self.camera.width, self.camera.height];
        let Image { rgba, size: smaller } = Image { size, rgba: self.rgba }.downscaled(factor)?;
        let mask = self.mask.map(|mask| downscaled_mask(size, &mask, smaller));
        Ok(Self { camera: self.camera.downscaled(factor), rgba, mask, depth: None, ..self })
    }
}
