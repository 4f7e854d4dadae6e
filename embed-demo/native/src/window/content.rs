//! What a window shows.

use std::time::Duration;

use pocketnerf_core::Error;

use super::status::status;
use crate::Failure;
use crate::paint::modes::Mode;
use crate::paint::picture::Picture;
use crate::show::{Figures, Next, Show};
use crate::view::View;

/// What a window shows: a model, or one that is still learnt.
pub trait Content {
    /// The view. Call [`change`](Self::change) when this or one of the next three has changed.
    fn view(&mut self) -> &mut View;

    /// What is shown of the scene.
    fn mode(&mut self) -> &mut Mode;

    /// Quality of the picture at rest.
    fn quality(&mut self) -> &mut f32;

    /// Pictures a second while something moves.
    fn fps(&mut self) -> &mut f64;

    /// Whether a mode can be shown.
    fn shows(&self, mode: Mode) -> bool;

    /// Starts a new picture.
    fn change(&mut self);

    /// Sets the size of the window, pixels.
    fn resize(&mut self, size: [u32; 2]);

    /// The next thing to do.
    fn next(&self) -> Next;

    /// Does a piece of work, short enough for a frame; returns whether there is another moving
    /// picture.
    ///
    /// # Errors
    /// One line: what cannot be painted.
    fn work(&mut self) -> Result<bool, Failure>;

    /// The picture, as large as the window.
    fn shown(&self) -> &Picture;

    /// A moving picture is on the screen, which took so long.
    fn presented(&mut self, took: Duration);

    /// The complete picture.
    ///
    /// # Errors
    /// Those of painting it.
    fn whole(&self) -> Result<Picture, Error>;

    /// Timings.
    fn figures(&mut self) -> &mut Figures;

    /// What the title says beside the name.
    fn progress(&self) -> String {
        String::new()
    }

    /// The text of the overlay, for a model of this name, with the last message.
    fn status(&self, name: &str, note: &str) -> String;
}

impl Content for Show<'_> {
    fn view(&mut self) -> &mut View {
        &mut self.view
    }

    fn mode(&mut self) -> &mut Mode {
        &mut self.mode
    }

    fn quality(&mut self) -> &mut f32 {
        &mut self.quality
    }

    fn fps(&mut self) -> &mut f64 {
        &mut self.pace.fps
    }

    fn shows(&self, mode: Mode) -> bool {
        self.painter().shows(mode)
    }

    fn change(&mut self) {
        Show::change(self);
    }

    fn resize(&mut self, size: [u32; 2]) {
        Show::resize(self, size);
    }

    fn next(&self) -> Next {
        Show::next(self)
    }

    fn work(&mut self) -> Result<bool, Failure> {
        Ok(Show::work(self)?)
    }

    fn shown(&self) -> &Picture {
        Show::shown(self)
    }

    fn presented(&mut self, _: Duration) {
        Show::presented(self);
    }

    fn whole(&self) -> Result<Picture, Error> {
        Show::whole(self)
    }

    fn figures(&mut self) -> &mut Figures {
        &mut self.figures
    }

    fn status(&self, name: &str, note: &str) -> String {
        status(self, name, note)
    }
}
