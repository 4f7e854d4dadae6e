//! Pictures of a model.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use pocketnerf_core::render::Detail;
use pocketnerf_core::{Camera, Model, Ray, RenderOptions};

use super::band::Band;
use super::bands::Bands;
use super::drawing::Drawing;
use super::program::Program;
use super::shown::{Drawn, Shown};
use super::{Error, Gpu, Picture, self_test};
use crate::frame::Frame;

/// Renders pictures of a model one after another, in memory that it keeps.
#[derive(Debug)]
pub struct Renderer {
    pub(super) program: Program,
    /// Memory that is not in use.
    room: Vec<Band>,
    pub(super) bands: Bands,
    /// When the last rows that were asked for were there.
    pub(super) busy_until: Option<Instant>,
    gpu_time: Option<Duration>,
    pub(super) shown: Shown,
    pub(super) drawn: Option<Drawn>,
    pub(super) drawing: VecDeque<Drawing>,
    pub(super) bytes: Vec<u8>,
    pub(super) detail: Detail,
    pub(super) min_transmittance: f32,
    max_samples_per_pixel: u32,
    picture: Picture,
}

/// Where rays come from.
#[derive(Clone, Copy, Debug)]
enum Source<'s> {
    Camera(&'s Camera),
    /// A ray a pixel, and where the camera that they are of looks.
    Rays(&'s [Ray], [f32; 3]),
}

/// Rows that the GPU has been asked for: the first one, and how many.
#[derive(Debug)]
struct Asked {
    index: wgpu::SubmissionIndex,
    band: Band,
    rows: [u32; 2],
    begun: Instant,
}

impl Renderer {
    /// Takes `model` into the GPU's memory, compiles the program that renders it, and compares
    /// a small picture of it with the CPU's.
    ///
    /// Of the `options`, `simd`, `limits`, `tuning` and the tolerances of interpolation do not
    /// matter for pictures: every pixel is rendered.
    ///
    /// # Errors
    /// Any [`Error`].
    pub fn new(gpu: &Gpu, model: &Model<'_>, options: &RenderOptions) -> Result<Self, Error> {
        let program = Program::new(gpu, model, options)?;
        let mut renderer = Self {
            bands: Bands::new(program.most_pixels()),
            program,
            room: Vec::new(),
            busy_until: None,
            gpu_time: None,
            shown: Shown::new(gpu, options.max_samples_per_pixel)?,
            drawn: None,
            drawing: VecDeque::new(),
            bytes: Vec::new(),
            detail: Detail::FINEST,
            min_transmittance: model.sampling.min_transmittance,
            max_samples_per_pixel: options.max_samples_per_pixel,
            picture: Picture::default(),
        };
        self_test::compare(&mut renderer, model, options)?;
        renderer.detail = options.detail;
        Ok(renderer)
    }

    /// Renders with other detail from now on.
    pub const fn set_detail(&mut self, detail: Detail) {
        self.detail = detail;
    }

    /// Has the GPU tell from now on how long it computes; false where it cannot.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn set_timed(&mut self) -> Result<bool, Error> {
        self.program.set_clock()
    }

    /// How long the GPU computed the last picture of [`render`](Self::render), copies and waits
    /// left out, if it [tells](Self::set_timed).
    #[must_use]
    pub const fn gpu_time(&self) -> Option<Duration> {
        self.gpu_time
    }

    /// Renders the picture that `camera` takes.
    ///
    /// # Errors
    /// [`Error::Device`] or [`Error::TooLarge`]; [`Error::Model`] where the field would have to
    /// be asked too often along a ray.
    pub fn render(&mut self, camera: &Camera) -> Result<&Picture, Error> {
        self.render_from(camera.width, camera.height, Source::Camera(camera))
    }

    /// Renders a picture of one ray a pixel, `width` in a row, of a camera that looks along
    /// the unit vector `axis`. What does not fill a row is left out.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn render_rays(
        &mut self,
        rays: &[Ray],
        width: u32,
        axis: [f32; 3],
    ) -> Result<&Picture, Error> {
        let height = rays.len() as u32 / width.max(1);
        self.render_from(width, height, Source::Rays(rays, axis))
    }

    fn render_from(
        &mut self,
        width: u32,
        height: u32,
        source: Source<'_>,
    ) -> Result<&Picture, Error> {
        let n = width as usize * height as usize;
        let picture = &mut self.picture;
        picture.rgba.resize(4 * n, 0.0);
        picture.depth.resize(n, 0.0);
        (picture.width, picture.height) = (width, height);
        (picture.samples, picture.hits) = (0, 0);
        self.gpu_time = None;
        let mut row = 0;
        let mut before: Option<Asked> = None;
        // While rows are copied from the GPU's memory, it renders the next ones.
        loop {
            let mut next = None;
            if row < height && width > 0 {
                let rows = self.bands.rows(width, height - row);
                next = Some(self.ask(source, width, [row, rows])?);
                row += rows;
            }
            let is_last = next.is_none();
            if let Some(asked) = std::mem::replace(&mut before, next) {
                self.take(asked, width)?;
            } else if is_last {
                return Ok(&self.picture);
            }
        }
    }

    /// Asks for rows: the first one, and how many.
    fn ask(&mut self, source: Source<'_>, width: u32, rows: [u32; 2]) -> Result<Asked, Error> {
        let n = width as usize * rows[1] as usize;
        let first = width as usize * rows[0] as usize;
        let rays = match source {
            Source::Rays(rays, _) => &rays[first..first + n],
            Source::Camera(_) => &[],
        };
        let size = [width, rows[0], rows[1]];
        let frame = frame(source, &self.detail, self.min_transmittance, size);
        let band = self.room(n as u64, !rays.is_empty())?;
        let begun = Instant::now();
        let index = self.program.ask(&band, &frame, rays, true);
        Ok(Asked { index, band, rows, begun })
    }

    /// Memory that is not in use, for so many pixels.
    fn room(&mut self, pixels: u64, has_rays: bool) -> Result<Band, Error> {
        let fits = |band: &Band| band.fits(pixels, has_rays);
        match self.room.iter().position(fits) {
            Some(i) => Ok(self.room.swap_remove(i)),
            None => {
                self.room.clear();
                self.program.band(pixels, has_rays)
            }
        }
    }

    /// Waits for rows, and copies them into the picture.
    fn take(&mut self, asked: Asked, width: u32) -> Result<(), Error> {
        let Asked { index, band, rows: [first, rows], begun } = asked;
        let n = width as usize * rows as usize;
        let first = width as usize * first as usize;
        let picture = &mut self.picture;
        let read = self.program.read_band(index, &band, n as u64, |colors, distances, times| {
            // The GPU may have been busy with the rows before, and the CPU with copying them.
            let now = Instant::now();
            let time = now - begun.max(self.busy_until.unwrap_or(begun));
            self.bands.took(rows * width, time);
            self.busy_until = Some(now);
            if let Some(time) = self.program.time(times) {
                *self.gpu_time.get_or_insert_default() += time;
            }
            let rgba = &mut picture.rgba[4 * first..][..4 * n];
            bytemuck::cast_slice_mut(rgba).copy_from_slice(colors);
            let depths = &mut picture.depth[first..][..n];
            let (mut sum, mut hits, mut most) = (0, 0, 0);
            for (to, [a, b, c, d, samples @ ..]) in depths.iter_mut().zip(distances) {
                let depth = f32::from_le_bytes([*a, *b, *c, *d]);
                *to = if depth < 0.0 { f32::INFINITY } else { depth };
                let samples = u32::from_le_bytes(*samples);
                sum += u64::from(samples);
                hits += u32::from(samples > 0);
                most = most.max(samples);
            }
            picture.samples += sum;
            picture.hits += u64::from(hits);
            most
        });
        let most = read?;
        self.room.push(band);
        self.check(most)
    }

    /// A ray may have so many samples.
    pub(super) fn check(&self, most: u32) -> Result<(), Error> {
        if most > self.max_samples_per_pixel {
            let allowed = u64::from(self.max_samples_per_pixel);
            return Err(pocketnerf_core::Error::TooManySamples { allowed }.into());
        }
        Ok(())
    }
}

fn frame(source: Source<'_>, detail: &Detail, min_transmittance: f32, rows: [u32; 3]) -> Frame {
    match source {
        Source::Rays(_, axis) => Frame::of_rays(axis, detail, min_transmittance, rows),
        Source::Camera(camera) => Frame::of_camera(camera, detail, min_transmittance, rows),
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::{SimdLevel, Tuning};

    use super::*;
    use crate::Software;

    /// A driver that is reset takes its device with it: an error, for the CPU to go on.
    #[test]
    fn a_lost_device_is_an_error() {
        let gpu = match Gpu::open(Software::Allowed) {
            Ok(gpu) => gpu,
            Err(why) => {
                assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "{why}");
                println!("{why}: nothing is tested");
                return;
            }
        };
        let bytes = include_bytes!("../../../../embed-demo/still-life.pnerf");
        let bytes = pocketnerf_formats::unpacked(bytes).unwrap();
        let file = pocketnerf_formats::open(&bytes).unwrap();
        let camera = Camera { width: 20, height: 20, ..file.about.camera.unwrap().camera() };
        let options = RenderOptions::new(&file.model, SimdLevel::detect(), Tuning::FAST);
        let mut renderer = Renderer::new(&gpu, &file.model, &options).unwrap();
        assert!(renderer.render(&camera).is_ok());
        gpu.device.destroy();
        for _ in 0..2 {
            let found = renderer.render(&camera).map(|picture| picture.hits);
            assert!(matches!(found, Err(Error::Device(_))), "{found:?}");
        }
        let again = Renderer::new(&gpu, &file.model, &options).map(|_| ());
        assert!(matches!(again, Err(Error::Device(_))), "{again:?}");
    }
}
