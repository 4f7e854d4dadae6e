//! What goes to files and terminals: pictures, and camera paths.

pub mod camera_path;
pub mod screenshot;
pub mod terminal;

use std::path::{Path, PathBuf};

use crate::Failure;
use crate::paint::modes::Mode;
use crate::paint::{Painter, Shot};
use crate::view::View;

/// The pictures to make.
#[derive(Clone, Debug)]
pub struct Request {
    /// What they show.
    pub mode: Mode,
    /// From 0, the fastest, to 1, the finest.
    pub quality: f32,
    /// Width and height; `None`: the model's own, or the terminal's.
    pub size: Option<[u32; 2]>,
    /// Number of views on a circle, written into a folder.
    pub orbit: Option<u32>,
    /// Columns of text on standard output; 0: those of the terminal.
    pub terminal: Option<u32>,
    /// A file, or a folder for an orbit.
    pub out: PathBuf,
}

impl Request {
    /// Makes the pictures, and returns the text to print.
    ///
    /// # Errors
    /// One line: what could not be rendered or written.
    pub fn run(&self, painter: &Painter<'_>, view: &View) -> Result<String, Failure> {
        if !painter.shows(self.mode) {
            return Err("only a scene in a box has normals; give another --mode".into());
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
            // Of any height.
            columns => [columns, u32::MAX / 2],
        };
        let picture = painter.picture(&self.shot(view, terminal::fit(size, room)))?.0;
        Ok(terminal::text(&picture))
    }

    fn shot(&self, view: &View, [width, height]: [u32; 2]) -> Shot {
        Shot { camera: view.camera(width, height), mode: self.mode, quality: self.quality }
    }
}
