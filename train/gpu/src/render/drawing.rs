//! Pictures that stay in the GPU's memory.

use std::time::{Duration, Instant};

use pocketnerf_core::{Camera, Display};

use super::{Error, Renderer};
use crate::frame::Frame;

/// Pixels that are being drawn.
#[derive(Debug)]
pub(super) struct Drawing {
    index: wgpu::SubmissionIndex,
    pixels: u32,
    begun: Instant,
}

impl Renderer {
    /// Renders the picture that `camera` takes, and leaves it in the GPU's memory: until the
    /// next one, [`rgba8`](Self::rgba8) reads it. Waits for the picture before the last
    /// alone, so that the GPU is never idle; large ones on slow GPUs are waited for in parts.
    ///
    /// # Errors
    /// As [`render`](Self::render); what goes wrong may be said by a later call.
    pub fn draw(&mut self, camera: &Camera) -> Result<(), Error> {
        let (width, height) = (camera.width, camera.height);
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 {
            self.drawn = None;
            return Ok(());
        }
        let mut drawn = match self.drawn.take().filter(|drawn| drawn.band.fits(pixels, false)) {
            Some(drawn) => drawn,
            None => self.shown.drawn(&self.program, pixels)?,
        };
        drawn.pixels = width * height;
        let mut row = 0;
        while row < height {
            let rows = self.bands.rows(width, height - row);
            let size = [width, row, rows];
            let frame = Frame::of_camera(camera, &self.detail, self.min_transmittance, size);
            let begun = Instant::now();
            let index = self.program.ask(&drawn.band, &frame.in_place(), &[], false);
            self.drawing.push_back(Drawing { index, pixels: rows * width, begun });
            row += rows;
            let ahead = if rows < height { 0 } else { 2 };
            while self.drawing.len() > ahead {
                self.wait()?;
            }
        }
        self.drawn = Some(drawn);
        Ok(())
    }

    /// Waits until all that is drawn is there.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn finish(&mut self) -> Result<(), Error> {
        while !self.drawing.is_empty() {
            self.wait()?;
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), Error> {
        let Some(Drawing { index, pixels, begun }) = self.drawing.pop_front() else {
            return Ok(());
        };
        let asked = Instant::now();
        self.program.gpu().wait(index)?;
        let now = Instant::now();
        // What is there at once has been there for who knows how long.
        if now - asked > Duration::from_micros(500) {
            self.bands.took(pixels, now - begun.max(self.busy_until.unwrap_or(begun)));
        }
        self.busy_until = Some(now);
        Ok(())
    }

    /// The picture that was drawn last, as screens and image files want it: sRGB over the
    /// background of `display`, as by [`Display::rgb8`], and opacity. A sixth of what
    /// [`render`](Self::render) reads is copied from the GPU's memory.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn rgba8(&mut self, display: &Display) -> Result<&[u8], Error> {
        self.bytes.clear();
        let Some(drawn) = &self.drawn else { return Ok(&self.bytes) };
        let index = self.shown.ask(self.program.gpu(), drawn, display);
        let most = self.program.gpu().read(index, &drawn.read, drawn.read_bytes(), |bytes| {
            let (most, pixels) = bytes.split_at(4);
            self.bytes.extend_from_slice(pixels);
            u32::from_le_bytes([most[0], most[1], most[2], most[3]])
        })?;
        // What was drawn is there too.
        if let Some(first) = self.drawing.front() {
            let now = Instant::now();
            let pixels = self.drawing.iter().map(|drawing| drawing.pixels).sum();
            self.bands.took(pixels, now - first.begun.max(self.busy_until.unwrap_or(first.begun)));
            self.busy_until = Some(now);
            self.drawing.clear();
        }
        self.check(most)?;
        Ok(&self.bytes)
    }
}
