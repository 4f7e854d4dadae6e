//! Pictures of a model.

use std::time::Instant;

use pocketnerf_core::render::Detail;
use pocketnerf_core::{Camera, Model, Ray, RenderOptions};

use super::bands::Bands;
use super::program::{Band, Program};
use super::{Error, Gpu, Picture, self_test};
use crate::frame::Frame;

/// Renders pictures of a model one after another, in memory that it keeps.
#[derive(Debug)]
pub struct Renderer {
    program: Program,
    band: Option<Band>,
    bands: Bands,
    detail: Detail,
    min_transmittance: f32,
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
            band: None,
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
        let mut row = 0;
        while row < height && width > 0 {
            let rows = self.bands.rows(width, height - row);
            let begun = Instant::now();
            self.render_rows(source, width, [row, rows])?;
            self.bands.took(rows * width, begun.elapsed());
            row += rows;
        }
        Ok(&self.picture)
    }

    fn render_rows(
        &mut self,
        source: Source<'_>,
        width: u32,
        [first_row, rows]: [u32; 2],
    ) -> Result<(), Error> {
        let n = width as usize * rows as usize;
        let first = width as usize * first_row as usize;
        let rays = match source {
            Source::Rays(rays, _) => &rays[first..first + n],
            Source::Camera(_) => &[],
        };
        let (pixels, has_rays) = (n as u64, !rays.is_empty());
        let frame = self.frame(source, [width, first_row, rows]);
        let band = match self.band.take().filter(|band| band.fits(pixels, has_rays)) {
            Some(band) => band,
            None => self.program.band(pixels, has_rays)?,
        };
        let picture = &mut self.picture;
        let most = self.program.run(&band, &frame, rays, |colors, distances| {
            let rgba = &mut picture.rgba[4 * first..][..4 * n];
            bytemuck::cast_slice_mut(rgba).copy_from_slice(colors);
            let depths = &mut picture.depth[first..][..n];
            let mut most = 0;
            for (to, [a, b, c, d, samples @ ..]) in depths.iter_mut().zip(distances) {
                let depth = f32::from_le_bytes([*a, *b, *c, *d]);
                *to = if depth < 0.0 { f32::INFINITY } else { depth };
                let samples = u32::from_le_bytes(*samples);
                picture.samples += u64::from(samples);
                picture.hits += u64::from(samples > 0);
                most = most.max(samples);
            }
            most
        })?;
        self.band = Some(band);
        if most > self.max_samples_per_pixel {
            let allowed = u64::from(self.max_samples_per_pixel);
            return Err(pocketnerf_core::Error::TooManySamples { allowed }.into());
        }
        Ok(())
    }

    fn frame(&self, source: Source<'_>, rows: [u32; 3]) -> Frame {
        match source {
            Source::Rays(_, axis) => {
                Frame::of_rays(axis, &self.detail, self.min_transmittance, rows)
            }
            Source::Camera(camera) => {
                Frame::of_camera(camera, &self.detail, self.min_transmittance, rows)
            }
        }
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
