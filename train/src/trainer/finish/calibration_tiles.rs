//! Calibration tiles: random tiles of the training views on which a finished model is
//! tuned.

use pocketnerf_core::{Camera, Error, Model, RenderOptions, Tile};

use crate::lens::{Lens, render_through};
use crate::pool::Pool;
use crate::random::Random;
use crate::trainer::pixels::rays::{Pixel, RaySource};
use crate::trainer::pixels::visibility::PixelVisibility;

/// Distinguishes these random numbers from others of the same seed.
const STREAM: u64 = 4;

/// Random tiles of the training views, the same for the same seed.
#[derive(Clone, Copy)]
pub(crate) struct CalibrationTiles<'t> {
    pub(crate) source: &'t RaySource,
    pub(crate) visibility: &'t PixelVisibility,
    pub(crate) seed: u64,
    /// How many.
    pub(crate) tiles: usize,
    /// Width and height of a tile.
    pub(crate) size: [u32; 2],
}

/// A tile that was rendered.
pub(crate) struct CalibrationTile<'t> {
    source: &'t RaySource,
    view: u32,
    camera: &'t Camera,
    lens: &'t Lens,
    background: [f32; 3],
    /// Which pixels.
    pub(crate) tile: Tile,
    /// Premultiplied.
    pub(crate) rgba: Vec<f32>,
    /// Samples that it took.
    pub(crate) samples: u64,
}

impl CalibrationTiles<'_> {
    /// Renders all tiles and returns what `look` makes of each.
    pub(crate) fn render<T: Send>(
        &self,
        model: &Model<'_>,
        options: &RenderOptions,
        look: impl Fn(&CalibrationTile<'_>) -> Result<T, Error> + Sync,
    ) -> Result<Vec<T>, Error> {
        let scratch = || vec![0.0; options.scratch_len()];
        Pool::default().map((0..self.tiles).collect(), scratch, |scratch, number| {
            let mut rendered = self.tile(number, model.display.background);
            let CalibrationTile { camera, lens, tile, rgba, .. } = &mut rendered;
            let stats = render_through(model, (camera, lens), *tile, options, scratch, rgba, None)?;
            rendered.samples = stats.samples;
            look(&rendered)
        })
    }

    /// A tile around a random pixel that sees something.
    fn tile(&self, number: usize, background: [f32; 3]) -> CalibrationTile<'_> {
        let mut random = Random::new(self.seed, [STREAM, number as u64, 0]);
        let seen = random.below(self.visibility.n_tiles());
        let Pixel { view, x, y } = self.visibility.pixel(self.source.cameras(), seen, &mut random);
        let camera = &self.source.cameras()[view as usize];
        let lens = &self.source.lenses()[view as usize];
        let [width, height] = [self.size[0].min(camera.width), self.size[1].min(camera.height)];
        let corner = |c: u32, side: u32, all: u32| c.saturating_sub(side / 2).min(all - side);
        let (x, y) = (corner(x, width, camera.width), corner(y, height, camera.height));
        let tile = Tile { x, y, width, height };
        let rgba = vec![0.0; 4 * tile.pixels()];
        CalibrationTile {
            source: self.source,
            view,
            camera,
            lens,
            background,
            tile,
            rgba,
            samples: 0,
        }
    }
}

impl CalibrationTile<'_> {
    /// Of the tile's premultiplied pixels that count against those of the photograph, both
    /// over the background, all colours together.
    pub(crate) fn squared_error(&self, rgba: &[f32]) -> f64 {
        let Self { source, view, camera, background, tile, .. } = self;
        let across = tile.x..tile.x + tile.width;
        let places =
            (tile.y..tile.y + tile.height).flat_map(|y| across.clone().map(move |x| (x, y)));
        let pixels = rgba.as_chunks::<4>().0.iter().zip(places);
        let index = |(x, y): (u32, u32)| (y * camera.width + x) as usize;
        let counted = pixels.filter(|(_, at)| source.is_exact(*view as usize, index(*at)));
        let errors = counted.map(|(ours, (x, y))| {
            let theirs = source.rgba(Pixel { view: *view, x, y });
            let [r, g, b, alpha] = theirs.map(|value| f32::from(value) / 255.0);
            let seen = ours[3];
            let differences = [r, g, b].into_iter().zip(ours).zip(*background);
            let squares = differences.map(|((theirs, ours), behind)| {
                let difference =
                    theirs * alpha + (1.0 - alpha) * behind - ours - (1.0 - seen) * behind;
                f64::from(difference * difference)
            });
            squares.sum::<f64>()
        });
        errors.sum()
    }
}
