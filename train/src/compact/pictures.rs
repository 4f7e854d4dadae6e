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
pub(crate) struct Pictures<'c> {
    cameras: &'c [Camera],
    settings: Settings,
    own: Rendered,
}

/// Pictures of a model.
#[derive(Debug)]
struct Rendered {
    /// Colours over the model's background, picture after picture.
    colors: Vec<Vec<f32>>,
    /// Samples that they took.
    samples: u64,
}

/// How another model's pictures differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Difference {
    /// Mean squared difference of their colours.
    pub(crate) error: f64,
    /// How many times as many samples they take.
    pub(crate) work: f64,
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

    /// How those of another model differ.
    ///
    /// # Errors
    /// Whatever rendering reports.
    pub(crate) fn difference(&self, model: &Model<'_>) -> Result<Difference, Error> {
        let other = rendered(model, self.cameras, &self.settings)?;
        let (mut sum, mut n) = (0.0, 0);
        for (picture, own) in other.colors.iter().zip(&self.own.colors) {
            n += own.len();
            sum += picture.iter().zip(own).map(|(a, b)| f64::from((a - b).powi(2))).sum::<f64>();
        }
        let work = other.samples as f64 / self.own.samples.max(1) as f64;
        Ok(Difference { error: sum / n.max(1) as f64, work })
    }
}

fn rendered(model: &Model<'_>, cameras: &[Camera], settings: &Settings) -> Result<Rendered, Error> {
    let mut renderer = Renderer::new(model, settings);
    let mut all = Rendered { colors: Vec::with_capacity(cameras.len()), samples: 0 };
    for camera in cameras {
        let picture = renderer.render(camera)?;
        all.colors.push(picture.over(model.display.background));
        all.samples += picture.stats.samples;
    }
    Ok(all)
}
