//! An open file, and the picture that is being rendered.

use alloc::borrow::Cow;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;

use pocketnerf_core::render::{Detail, RenderStats, Tiles};
use pocketnerf_core::{
    Camera, Model, RenderOptions, Sampling, SimdLevel, Tile, Tuning, math, render_tile,
};
use pocketnerf_formats::{ModelFile, open_verified, unpacked};
use pocketnerf_gpu::Frame;

use crate::facts::Facts;
use crate::gpu::Parts;

/// A camera in the dataset's coordinates.
pub type View = Camera;

/// An open file, with the memory that its pictures need.
#[derive(Debug)]
pub struct Scene {
    file: ModelFile<'static>,
    model: Model<'static>,
    /// The usual ones.
    options: RenderOptions,
    scratch: Vec<f32>,
    /// Colours of a tile, then depths.
    rgba: Vec<f32>,
    pixels: Vec<u8>,
    /// The last picture that was started.
    picture: Option<(Camera, RenderOptions)>,
    /// Statistics of its last tile.
    stats: RenderStats,
}

impl Scene {
    /// Opens a file, packed or not, with every byte checked.
    ///
    /// # Errors
    /// One line: why the file is refused.
    pub fn open(bytes: &'static [u8], simd: SimdLevel) -> Result<Self, String> {
        let bytes = match unpacked(bytes).map_err(|error| error.to_string())? {
            Cow::Borrowed(ordinary) => ordinary,
            // Until the instance is dropped, as the file.
            Cow::Owned(unpacked) => unpacked.leak(),
        };
        let file = open_verified(bytes).map_err(|error| error.to_string())?;
        let coordinates = file.about.scene;
        coordinates.similarity().validate().map_err(|error| error.to_string())?;
        // The scene lives as long as the instance: the table is never freed.
        let table = vec![0; file.model.table_len()].leak();
        let model = file.model.with_table(table).map_err(|error| error.to_string())?;
        let options = RenderOptions::new(&model, simd, Tuning::FAST);
        Ok(Self {
            file,
            model,
            options,
            scratch: vec![0.0; options.scratch_len()],
            rgba: vec![0.0; 5 * Tiles::MOST_PIXELS],
            pixels: vec![0; 4 * Tiles::MOST_PIXELS],
            picture: None,
            stats: RenderStats::default(),
        })
    }

    /// Facts about it, in numbers.
    #[must_use]
    pub fn facts(&self) -> Facts {
        Facts::of(&self.file)
    }

    /// Facts about it, in words: 0 the name of the scene, 1 the kind of field, 2 the method, 3 the
    /// program that wrote the file, 4 the dataset. Empty if the file has none.
    #[must_use]
    pub fn text(&self, which: u32) -> &str {
        let provenance = self.file.about.provenance.unwrap_or_default();
        match which {
            0 => self.file.about.scene.name.unwrap_or_default(),
            1 => self.file.model.field.kind(),
            2 => provenance.method,
            3 => provenance.program,
            4 => provenance.dataset,
            _ => "",
        }
    }

    /// The file's own camera, or one beside the scene, for a picture of this size, which shows
    /// all that the file's own picture shows. The same as `camera` of `pocketnerf.js`.
    #[must_use]
    pub fn own_camera(&self, width: u32, height: u32) -> View {
        let facts = self.facts().0;
        let [tangent, own_width, own_height] = [facts[16], facts[17], facts[18]];
        let mut focal = 0.5 * width as f32 / tangent;
        let wide =
            f64::from(width) * f64::from(own_height) / (f64::from(height) * f64::from(own_width));
        if wide > 1.0 {
            focal = (f64::from(focal) / wide) as f32;
        }
        let mut pose = [0.0; 16];
        pose.copy_from_slice(&facts[..16]);
        Camera {
            width,
            height,
            focal: [focal; 2],
            center: [0.5 * width as f32, 0.5 * height as f32],
            camera_to_world: pose,
        }
    }

    /// Starts a picture, and returns the number of its tiles, to be rendered one by one.
    /// `quality`: 0, the fastest, to 1, the finest.
    ///
    /// # Errors
    /// One line: why the camera is invalid.
    pub fn begin(&mut self, view: &View, quality: f32) -> Result<u32, String> {
        view.validate().map_err(|error| error.to_string())?;
        if quality.is_nan() {
            return Err("quality: not a number, expected 0 to 1".into());
        }
        let camera = self.file.about.scene.camera_to_model(view);
        let options = RenderOptions { detail: self.model.detail(quality), ..self.options };
        self.picture = Some((camera, options));
        Ok(Tiles::new(view.width, view.height).len() as u32)
    }

    /// Renders a tile of the picture: red, green, blue and 255 in four bytes a
    /// pixel in sRGB, over the model's background, row after row. With depth, that is in
    /// [`depths`](Self::depths) afterwards; interpolated pixels may differ by the tolerance.
    ///
    /// # Errors
    /// One line: no such tile, or the model cannot be rendered.
    pub fn tile(&mut self, number: u32, with_depth: bool) -> Result<(Tile, &[u8]), String> {
        let (camera, options) = self.picture.as_ref().ok_or("tile: no picture was started")?;
        let tile = Tiles::new(camera.width, camera.height).get(number);
        let tile = tile.ok_or("tile: no tile of this number")?;
        let (rgba, depth) = self.rgba.split_at_mut(4 * Tiles::MOST_PIXELS);
        let rgba = &mut rgba[..4 * tile.pixels()];
        let depth = with_depth.then_some(&mut depth[..tile.pixels()]);
        let stats = render_tile(&self.model, camera, tile, options, &mut self.scratch, rgba, depth);
        self.stats = stats.map_err(|error| error.to_string())?;
        Ok((tile, self.show(tile.pixels())))
    }

    /// What a GPU needs to render this.
    ///
    /// # Errors
    /// One line: why no GPU renders it.
    pub fn parts(&self) -> Result<Parts, String> {
        Parts::new(&self.model, &self.options).map_err(|error| error.to_string())
    }

    /// The uniform buffer of the picture; the page says of which rows.
    #[must_use]
    pub fn frame(&self) -> Option<[u32; 36]> {
        let (camera, options) = self.picture.as_ref()?;
        let least = self.model.sampling.min_transmittance;
        let rows = [camera.width, 0, camera.height];
        Some(Frame::of_camera(camera, &options.detail, least, rows).words())
    }

    /// The depths of the last tile that was rendered with them, scene units.
    #[must_use]
    pub fn depths(&self) -> &[f32] {
        &self.rgba[4 * Tiles::MOST_PIXELS..]
    }

    /// Colours of [`Tiles::MOST_PIXELS`], four numbers a pixel, premultiplied, and their depths.
    pub const fn colors(&mut self) -> &mut [f32] {
        self.rgba.as_mut_slice()
    }

    /// The first pixels of [`colors`](Self::colors), as [`tile`](Self::tile) gives them.
    pub fn show(&mut self, pixels: usize) -> &[u8] {
        let pixels = pixels.min(Tiles::MOST_PIXELS);
        let (from, to) = (self.rgba.as_chunks().0, self.pixels.as_chunks_mut().0);
        for (to, from) in to[..pixels].iter_mut().zip(from) {
            let [r, g, b] = self.model.display.rgb8(*from);
            *to = [r, g, b, 255];
        }
        &self.pixels[..4 * pixels]
    }

    /// The address of a tile's bytes.
    pub(crate) const fn pixels(&self) -> *const u8 {
        self.pixels.as_ptr()
    }

    /// Statistics of the last tile.
    #[must_use]
    pub const fn stats(&self) -> RenderStats {
        self.stats
    }

    /// The distance of what `view` shows at (`x`, `y`), pixels from the top left corner, and its
    /// position: where half of the light is absorbed. Infinite if there is nothing.
    ///
    /// # Errors
    /// One line: the camera is invalid, or the space is not a box and has no distances.
    pub fn pick(&mut self, view: &View, [x, y]: [f32; 2]) -> Result<[f32; 4], String> {
        view.validate().map_err(|error| error.to_string())?;
        if ![x, y].iter().all(|v| v.abs() < 1e9) {
            return Err("pick: x and y, expected pixels below 1e9".into());
        }
        if self.model.space.scene_box().is_none() {
            return Err("pick: the space is not a box, and has no distances".into());
        }
        // A picture of one pixel, in the model's coordinates.
        let camera = self.file.about.scene.camera_to_model(view);
        let center = [camera.center[0] - x + 0.5, camera.center[1] - y + 0.5];
        let camera = Camera { width: 1, height: 1, center, ..camera };
        let depth = self.file.about.scene.scale * self.median(&camera)?;
        let ray = view.ray(x, y);
        let [a, b, c] = [0, 1, 2].map(|a| ray.origin[a] + depth * ray.direction[a]);
        Ok([depth, a, b, c])
    }

    /// The median depth, scene units, as `Probe::depths` finds it. That would be 20 kB of code;
    /// this bisects over the opacity that the renderer finds up to some step.
    fn median(&mut self, camera: &Camera) -> Result<f32, String> {
        let Sampling { step, near, far, .. } = self.model.sampling;
        let options = RenderOptions { detail: Detail::FINEST, ..self.options };
        let mut model = self.model;
        // Otherwise rays would end before they are fully opaque.
        model.sampling.min_transmittance = 1e-12;
        let mut passes = |steps: u32| {
            // The last sample lies half a step before the end of the last step.
            model.sampling.far = near + (steps as f32 - 0.25) * step;
            let tile = Tile { x: 0, y: 0, width: 1, height: 1 };
            let (scratch, rgba) = (&mut self.scratch, &mut self.rgba[..4]);
            render_tile(&model, camera, tile, &options, scratch, rgba, None)
                .map_err(|error| error.to_string())?;
            Ok::<f32, String>(1.0 - rgba[3])
        };
        let (mut low, mut high) = (0, ((far - near) / step) as u32 + 1);
        let (mut before, mut after) = (1.0, passes(high)?);
        if after > 0.5 {
            return Ok(f32::INFINITY);
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            let found = passes(middle)?;
            match found > 0.5 {
                true => (low, before) = (middle, found),
                false => (high, after) = (middle, found),
            }
        }
        // Within the step light fades exponentially.
        let part = match after > 0.0 {
            true => math::ln(before / 0.5) / math::ln(before / after),
            false => 0.0,
        };
        Ok(near + (low as f32 + part) * step)
    }
}
