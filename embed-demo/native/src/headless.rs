//! Pictures without a window: files, and text for a terminal.

use std::path::{Path, PathBuf};

use crate::modes::Mode;
use crate::painter::{Painter, Shot};
use crate::view::View;
use crate::{Failure, screenshot, terminal};

/// Which pictures, and where to.
#[derive(Clone, Debug)]
pub struct Request {
    /// What of.
    pub mode: Mode,
    /// How fine.
    pub quality: f32,
    /// Width and height; the model's own, or what fits in the terminal.
    pub size: Option<[u32; 2]>,
    /// So many views in a circle, into a folder.
    pub orbit: Option<u32>,
    /// As text on standard output, in so many columns; 0: as many as there are.
    pub terminal: Option<u32>,
    /// A file, or a folder for an orbit.
    pub out: PathBuf,
}

impl Request {
    /// Makes the pictures; what is said about them.
    ///
    /// # Errors
    /// One line: what could not be rendered or written.
    pub fn run(&self, painter: &Painter<'_>, view: &View) -> Result<String, Failure> {
        if !painter.shows(self.mode) {
            return Err("a forward-facing capture has no normals; give another --mode".into());
        }
        match (self.terminal, self.orbit) {
            (Some(width), _) => self.text(painter, view, width),
            (None, Some(views)) => {
                let folder = &self.out;
                std::fs::create_dir_all(folder).map_err(|e| {
                    format!(
                        "{}: this folder cannot be made: {e}; give another --out",
                        folder.display()
                    )
                })?;
                for (i, view) in view.orbit(views).iter().enumerate() {
                    self.file(painter, view, &folder.join(format!("{i:03}.png")))?;
                }
                Ok(format!("{}: {views} pictures\n", folder.display()))
            }
            (None, None) => {
                self.file(painter, view, &self.out)?;
                Ok(format!("{}\n", self.out.display()))
            }
        }
    }

    fn file(&self, painter: &Painter<'_>, view: &View, path: &Path) -> Result<(), Failure> {
        let picture = painter.picture(&self.shot(view, self.size.unwrap_or(view.size())))?.0;
        Ok(screenshot::write(path, &picture)?)
    }

    fn text(&self, painter: &Painter<'_>, view: &View, width: u32) -> Result<String, Failure> {
        let size = self.size.unwrap_or(view.size());
        let room = match width {
            0 => terminal::room(),
            // As high as it likes to be.
            columns => [columns, u32::MAX / 2],
        };
        let picture = painter.picture(&self.shot(view, terminal::fit(size, room)))?.0;
        Ok(terminal::text(&picture))
    }

    fn shot(&self, view: &View, [width, height]: [u32; 2]) -> Shot {
        Shot { camera: view.camera(width, height), mode: self.mode, quality: self.quality }
    }
}
