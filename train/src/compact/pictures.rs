//! Pictures by which a model and a smaller one are compared.

use pocketnerf_core::{Camera, Error, Model};

use crate::dataset::thin;
use crate::picture::{Renderer, Settings};

/// Views from which pictures are compared.
pub const VIEWS: usize = 12;
/// Their longer sides, pixels, where there is time for them.
pub const SIDE: u32 = 128;

/// Cameras from which pictures of such models are compared: a dozen of these, evenly spread, of at
/// most so many pixels along their longer sides.
#[must_use]
pub fn small(mut cameras: Vec<Camera>, side: u32) -> Vec<Camera> {
    thin(&mut cameras, VIEWS);
    let longer = |camera: &Camera| camera.width.max(camera.height);
    cameras.iter().map(|camera| camera.downscaled(longer(camera).div_ceil(side))).collect()
}

/// A model's own pictures.
#[derive(Debug)]
pub struct Pictures<'c> {
    cameras: &'c [Camera],
    settings: Settings,
    /// Colours over the model's background, picture after picture.
    own: Vec<Vec<f32>>,
}

impl<'c> Pictures<'c> {
    pub(crate) fn of(
        model: &Model<'_>,
        cameras: &'c [Camera],
        settings: &Settings,
    ) -> Result<Self, Error> {
        let settings = Settings { quality: 1.0, depth: false, ..*settings };
        let own = rendered(model, cameras, &settings)?;
        Ok(Self { cameras, settings, own })
    }

    /// Mean squared difference of another model's pictures.
    ///
    /// # Errors
    /// Whatever rendering reports.
    pub fn difference(&self, model: &Model<'_>) -> Result<f64, Error> {
        let (mut sum, mut n) = (0.0, 0);
        for (picture, own) in rendered(model, self.cameras, &self.settings)?.iter().zip(&self.own) {
            n += own.len();
            sum += picture.iter().zip(own).map(|(a, b)| f64::from((a - b).powi(2))).sum::<f64>();
        }
        Ok(sum / n.max(1) as f64)
    }
}

fn rendered(
    model: &Model<'_>,
    cameras: &[Camera],
    settings: &Settings,
) -> Result<Vec<Vec<f32>>, Error> {
    let mut renderer = Renderer::new(model, settings);
    let over = |camera| Ok(renderer.render(camera)?.over(model.display.background));
    cameras.iter().map(over).collect()
}
