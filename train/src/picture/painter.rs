//! Whatever takes pictures of a scene.

use pocketnerf_core::{Camera, Error};

use super::{Picture, Renderer};
use crate::lens::Lens;

/// Renders pictures one after another, in memory that it keeps: a model's [`Renderer`], or that of
/// another representation of scenes.
pub trait Painter {
    /// The picture that `camera` takes through `lens`: premultiplied RGBA, on all threads of the
    /// current pool.
    ///
    /// # Errors
    /// Whatever rendering reports.
    fn paint(&mut self, camera: &Camera, lens: &Lens) -> Result<&Picture, Error>;
}

impl Painter for Renderer<'_> {
    fn paint(&mut self, camera: &Camera, lens: &Lens) -> Result<&Picture, Error> {
        self.render_through(camera, lens)
    }
}
