//! Pictures.

use std::ops::RangeInclusive;

use pocketnerf_core::render::{RenderStats, Tiles};
use pocketnerf_core::{Camera as CoreCamera, RenderOptions, Tile as CoreTile, render_tile};

use crate::border;
use crate::camera::Camera;
use crate::image::{Image, Target};
use crate::model::Model;
use crate::options::{Memory, Options};
use crate::status::{Error, Failure, Status, call};

/// A rectangle of pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Statistics of rendering, to be summed over tiles.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Rays cast; the other pixels are interpolated, or known to be empty.
    pub rays: u64,
    /// Evaluations of the field.
    pub samples: u64,
    /// Rays with at least one evaluation.
    pub hits: u64,
}

/// Width and height of tiles that need little memory.
const SMALL_TILE: [u32; 2] = [32, 16];

/// How a picture is cut into tiles.
enum Cut {
    /// The tiles of all hosts.
    Usual(Tiles),
    Small([u32; 2]),
}

impl Cut {
    fn new(width: u32, height: u32, memory: Memory) -> Self {
        match memory {
            Memory::Fast => Self::Usual(Tiles::new(width, height)),
            Memory::Small => Self::Small([width, height]),
        }
    }

    fn len(&self) -> u32 {
        match self {
            Self::Usual(tiles) => tiles.len() as u32,
            Self::Small([width, height]) => {
                width.div_ceil(SMALL_TILE[0]) * height.div_ceil(SMALL_TILE[1])
            }
        }
    }

    fn get(&self, number: u32) -> Result<CoreTile, Failure> {
        let tile = match self {
            Self::Usual(tiles) => tiles.get(number),
            Self::Small([width, height]) => {
                let columns = width.div_ceil(SMALL_TILE[0]);
                let (x, y) = (number % columns * SMALL_TILE[0], number / columns * SMALL_TILE[1]);
                (number < self.len()).then(|| CoreTile {
                    x,
                    y,
                    width: SMALL_TILE[0].min(width - x),
                    height: SMALL_TILE[1].min(height - y),
                })
            }
        };
        let n = self.len();
        let text = || format!("number: {number} of {n} tiles, the first is 0");
        tile.ok_or_else(|| Failure::new(Status::Argument, text()))
    }
}

/// The most pixels of a tile.
const fn most_pixels(memory: Memory) -> usize {
    match memory {
        Memory::Fast => Tiles::MOST_PIXELS,
        Memory::Small => (SMALL_TILE[0] * SMALL_TILE[1]) as usize,
    }
}

/// The renderer's scratch, and a tile with depth.
pub(crate) fn scratch_len(options: &Options, render: &RenderOptions) -> Result<usize, Failure> {
    Ok(render.scratch_len() + 5 * most_pixels(options.memory()?))
}

/// What the tiles of a picture have in common.
struct Job<'c> {
    model: &'c Model,
    camera: CoreCamera,
    memory: Memory,
    options: RenderOptions,
    target: Target,
    scratch: &'c mut [f32],
}

impl<'c> Job<'c> {
    /// # Safety
    /// As for [`pnrf_render`].
    unsafe fn new(
        model: *const Model,
        camera: *const Camera,
        options: *const Options,
        image: *const Image,
        (scratch, scratch_length): (*mut f32, usize),
    ) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        let (model, camera, options, image) = unsafe {
            let (model, camera) = (border::read(model, "model")?, border::read(camera, "camera")?);
            (model, camera, Options::read(options)?, border::read(image, "image")?)
        };
        let camera = camera.to_model(model)?;
        let color_space = model.file().model.display.color_space;
        let target = Target::new(image, &camera, model.similarity().scale, color_space)?;
        let memory = options.memory()?;
        let render = options.render(model)?;
        let needed = scratch_len(&options, &render)?;
        // SAFETY: the caller's promise.
        let scratch = unsafe { border::room(scratch, scratch_length, "scratch")? };
        if scratch.len() < needed {
            let text = format_args!("scratch holds {scratch_length} values, {needed} are needed");
            return Err(Failure::new(Status::Buffer, text));
        }
        Ok(Self { model, camera, memory, options: render, target, scratch })
    }

    fn cut(&self) -> Cut {
        Cut::new(self.camera.width, self.camera.height, self.memory)
    }

    /// # Safety
    /// Nobody else uses the tile's part of the image.
    unsafe fn render(&mut self, tile: CoreTile) -> Result<RenderStats, Failure> {
        let most = most_pixels(self.memory);
        let (rgba, scratch) = self.scratch.split_at_mut(4 * most);
        let (depth, scratch) = scratch.split_at_mut(most);
        let (rgba, depth) = (&mut rgba[..4 * tile.pixels()], &mut depth[..tile.pixels()]);
        let depth = if self.target.wants_depth() { depth } else { &mut [] };
        let (model, wanted) = (&self.model.file().model, !depth.is_empty());
        let (camera, options) = (&self.camera, &self.options);
        let stats = {
            let depth = wanted.then_some(&mut *depth);
            render_tile(model, camera, tile, options, scratch, rgba, depth)?
        };
        // SAFETY: the tile is one of the camera's picture; the caller's promise.
        unsafe { self.target.write(camera, tile, rgba.as_chunks().0, depth) };
        Ok(stats)
    }
}

impl From<RenderStats> for Stats {
    fn from(stats: RenderStats) -> Self {
        let RenderStats { rays, samples, hits } = stats;
        Self { rays, samples, hits }
    }
}

/// What a picture is made of.
type Parts = (*const Model, *const Camera, *const Options, *const Image);

/// Renders the tiles that `numbers` chooses of a picture's, one after another.
///
/// # Safety
/// The crate's one condition; of the image, for these tiles' part.
unsafe fn draw(
    (model, camera, options, image): Parts,
    scratch: (*mut f32, usize),
    (stats, error): (*mut Stats, *mut Error),
    numbers: impl FnOnce(&Cut) -> RangeInclusive<u32>,
) -> Status {
    let work = || {
        border::check_unless_null(stats, "stats")?;
        // SAFETY: the caller's promise.
        let mut job = unsafe { Job::new(model, camera, options, image, scratch)? };
        let (cut, mut took) = (job.cut(), RenderStats::default());
        for number in numbers(&cut) {
            // SAFETY: the tile's part of the image is the call's alone.
            took += unsafe { job.render(cut.get(number)?)? };
        }
        // SAFETY: the caller's promise.
        unsafe { border::write_unless_null(stats, took.into(), "stats") }
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// Renders a picture on the calling thread.
///
/// `image` holds all of the camera's picture. `scratch` has `scratch_length` values, at least
/// those of `pnrf_scratch_length`. `stats` may be null. If the call fails, only `error` is
/// written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_render(
    model: *const Model,
    camera: *const Camera,
    options: *const Options,
    image: *const Image,
    scratch: *mut f32,
    scratch_length: usize,
    stats: *mut Stats,
    error: *mut Error,
) -> Status {
    let scratch = (scratch, scratch_length);
    // SAFETY: the caller's promise.
    unsafe {
        draw((model, camera, options, image), scratch, (stats, error), |cut| 0..=cut.len() - 1)
    }
}

/// Renders one tile of a picture, `number` from 0 to `pnrf_tile_count` - 1, into its place in
/// the image of the whole picture. Otherwise the same as `pnrf_render`, which renders one tile
/// after another. Several threads may render tiles of one image at the same time, each with its
/// own scratch.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_render_tile(
    model: *const Model,
    camera: *const Camera,
    options: *const Options,
    number: u32,
    image: *const Image,
    scratch: *mut f32,
    scratch_length: usize,
    stats: *mut Stats,
    error: *mut Error,
) -> Status {
    let scratch = (scratch, scratch_length);
    // SAFETY: the caller's promise.
    unsafe { draw((model, camera, options, image), scratch, (stats, error), |_| number..=number) }
}

/// The number of tiles of a picture of this size; 0 if the size or the options are invalid.
/// `options` as for rendering.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_tile_count(width: u32, height: u32, options: *const Options) -> u32 {
    let mut count = 0;
    let work = || {
        // SAFETY: the caller's promise.
        let memory = unsafe { Options::read(options)? }.memory()?;
        count = cut(width, height, memory)?.len();
        Ok(())
    };
    // SAFETY: no error is written.
    unsafe { call(std::ptr::null_mut(), work) };
    count
}

/// Writes the rectangle that a tile covers to `tile`, to show tiles as they are rendered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_tile(
    width: u32,
    height: u32,
    options: *const Options,
    number: u32,
    tile: *mut Tile,
    error: *mut Error,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let memory = unsafe { Options::read(options)? }.memory()?;
        let CoreTile { x, y, width, height } = cut(width, height, memory)?.get(number)?;
        // SAFETY: the caller's promise.
        unsafe { border::write(tile, Tile { x, y, width, height }, "tile") }
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

fn cut(width: u32, height: u32, memory: Memory) -> Result<Cut, Failure> {
    let most = crate::camera::MAX_SIDE;
    if [width, height].iter().all(|side| (1..=most).contains(side)) {
        return Ok(Cut::new(width, height, memory));
    }
    let text = format!("{width}x{height} pixels, expected 1 to {most} a side");
    Err(Failure::new(Status::Argument, text))
}
