//! The caller's pictures: where and how the pixels of a tile are written.

use std::ffi::c_void;
use std::slice;

use pocketnerf_core::{Camera, ColorSpace, Tile, pixel};

use crate::options::unknown;
use crate::status::{Failure, Status};

/// The format of a pixel. Bytes are sRGB; `float` values are in the model's own colour space,
/// see `is_linear` of `PnrfInfo`.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Four bytes: red, green, blue, alpha.
    Rgba8 = 0,
    /// Four bytes: blue, green, red, alpha, as in many window systems.
    Bgra8 = 1,
    /// Four `float` values: red, green, blue, alpha.
    RgbaF32 = 2,
}

impl Format {
    fn of(code: u32) -> Result<Self, Failure> {
        match code {
            0 => Ok(Self::Rgba8),
            1 => Ok(Self::Bgra8),
            2 => Ok(Self::RgbaF32),
            other => Err(unknown("format", other)),
        }
    }
}

/// How transparency is stored.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alpha {
    /// Pixels are composited over the image's background; alpha is 1.
    Background = 0,
    /// Colours are multiplied by alpha, without background: out = this + (1 - alpha) * behind.
    /// Bytes of a linear model are to be decoded first, as sRGB textures do.
    Premultiplied = 1,
    /// Colours are not multiplied by alpha, as in PNG files.
    Straight = 2,
}

impl Alpha {
    fn of(code: u32) -> Result<Self, Failure> {
        match code {
            0 => Ok(Self::Background),
            1 => Ok(Self::Premultiplied),
            2 => Ok(Self::Straight),
            other => Err(unknown("alpha", other)),
        }
    }
}

/// The kind of distance that a depth is.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthKind {
    /// From the camera's position, along the ray.
    Distance = 0,
    /// From the plane through the camera, along its viewing direction, as for a z-buffer.
    Z = 1,
}

impl DepthKind {
    fn of(code: u32) -> Result<Self, Failure> {
        match code {
            0 => Ok(Self::Distance),
            1 => Ok(Self::Z),
            other => Err(unknown("depth_kind", other)),
        }
    }
}

/// A whole picture in the caller's memory, at any alignment, rows from top to bottom. Only the
/// pixels of rendered tiles are written. Set the struct to zero first: the default is RGBA in
/// bytes over black, without depth or padding.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// The upper left pixel, or null for depth alone.
    pub pixels: *mut c_void,
    /// Size of `pixels` in bytes.
    pub size: usize,
    /// Bytes from one row to the next; 0: rows without padding.
    pub stride: usize,
    /// A `PnrfFormat`.
    pub format: u32,
    /// A `PnrfAlpha`.
    pub alpha: u32,
    /// Red, green and blue, 0 to 1, for `PNRF_ALPHA_BACKGROUND`: in the model's own colour
    /// space, as in `PnrfInfo`.
    pub background: [f32; 3],
    /// 1: rows from bottom to top, as in OpenGL textures; for depth too.
    pub bottom_up: u32,
    /// One `float` per pixel: the expected distance in the caller's units, infinite where
    /// there is nothing. Null for none.
    pub depth: *mut f32,
    /// Size of `depth` in bytes.
    pub depth_size: usize,
    /// Bytes from one row to the next; 0: rows without padding.
    pub depth_stride: usize,
    /// A `PnrfDepthKind`.
    pub depth_kind: u32,
}

/// Rows of pixels, written to by this call alone.
#[derive(Clone, Copy, Debug)]
struct Plane {
    /// Null for none.
    start: *mut u8,
    stride: usize,
    pixel: usize,
}

impl Plane {
    fn new(
        start: *mut u8,
        [size, stride]: [usize; 2],
        pixel: usize,
        camera: &Camera,
        name: &str,
    ) -> Result<Self, Failure> {
        let (row, rows) = (camera.width as usize * pixel, camera.height as usize);
        let stride = if stride == 0 { row } else { stride };
        if start.is_null() {
            return Ok(Self { start, stride, pixel });
        }
        if stride < row {
            let text = format_args!("{name}: stride of {stride} bytes, rows have {row}");
            return Err(Failure::new(Status::Buffer, text));
        }
        let needed = stride.checked_mul(rows - 1).and_then(|bytes| bytes.checked_add(row));
        match needed {
            Some(needed) if needed <= size && size <= isize::MAX as usize => {
                Ok(Self { start, stride, pixel })
            }
            Some(needed) => {
                let text = format_args!("{name}: room for {size} bytes where {needed} are needed");
                Err(Failure::new(Status::Buffer, text))
            }
            None => Err(Failure::new(Status::Buffer, format_args!("{name}: stride too large"))),
        }
    }

    /// `pixels` pixels from column `x` of row `y`.
    ///
    /// # Safety
    /// They lie within the camera's picture, the memory is valid, and nobody else reads or writes
    /// them while the result is used.
    unsafe fn row(&mut self, [x, y]: [u32; 2], pixels: u32) -> &mut [u8] {
        // SAFETY: `new` has found room for all rows.
        unsafe {
            let start = self.start.add(y as usize * self.stride + x as usize * self.pixel);
            slice::from_raw_parts_mut(start, pixels as usize * self.pixel)
        }
    }
}

/// An image that fits a camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pixels: Plane,
    format: Format,
    alpha: Alpha,
    background: [f32; 3],
    color_space: ColorSpace,
    /// Number of rows, if they are upside down.
    upside_down: Option<u32>,
    depth: Plane,
    depth_kind: DepthKind,
    /// Caller's units per unit of the model.
    scale: f32,
}

impl Target {
    /// For pictures of a model, a unit of which is `scale` of the caller's.
    pub(crate) fn new(
        image: &Image,
        camera: &Camera,
        scale: f32,
        color_space: ColorSpace,
    ) -> Result<Self, Failure> {
        let format = Format::of(image.format)?;
        let alpha = Alpha::of(image.alpha)?;
        let depth_kind = DepthKind::of(image.depth_kind)?;
        let upside_down = match image.bottom_up {
            0 => None,
            1 => Some(camera.height),
            other => return Err(unknown("bottom_up", other)),
        };
        if !image.background.iter().all(|c| c.is_finite()) {
            return Err(Failure::new(Status::Argument, "background: not finite"));
        }
        if image.pixels.is_null() && image.depth.is_null() {
            return Err(Failure::new(Status::Null, "pixels and depth are both null"));
        }
        let pixel = if format == Format::RgbaF32 { 16 } else { 4 };
        let layout = [image.size, image.stride];
        let pixels = Plane::new(image.pixels.cast(), layout, pixel, camera, "pixels")?;
        let layout = [image.depth_size, image.depth_stride];
        let depth = Plane::new(image.depth.cast(), layout, 4, camera, "depth")?;
        let background = image.background;
        Ok(Self {
            pixels,
            format,
            alpha,
            background,
            color_space,
            upside_down,
            depth,
            depth_kind,
            scale,
        })
    }

    pub(crate) const fn wants_depth(&self) -> bool {
        !self.depth.start.is_null()
    }

    /// Writes a rendered, premultiplied tile, and its depth if there is a place for it.
    ///
    /// # Safety
    /// The tile lies within the camera's picture, the image's memory is valid, and nobody else
    /// uses the tile's part of it during the call.
    pub(crate) unsafe fn write(
        self,
        camera: &Camera,
        tile: Tile,
        rgba: &[[f32; 4]],
        depth: &[f32],
    ) {
        let width = tile.width as usize;
        let (mut pixels, mut plane) = (self.pixels, self.depth);
        for (y, row) in (tile.y..).zip(rgba.chunks_exact(width)) {
            if self.pixels.start.is_null() {
                break;
            }
            // SAFETY: the caller's promise.
            let to = unsafe { pixels.row([tile.x, self.turned(y)], tile.width) };
            self.write_row(row, to);
        }
        for (y, row) in (tile.y..).zip(depth.chunks_exact(width)) {
            // SAFETY: the caller's promise.
            let to = unsafe { plane.row([tile.x, self.turned(y)], tile.width) };
            let to = to.as_chunks_mut::<4>().0.iter_mut();
            for ((x, depth), to) in (tile.x..).zip(row).zip(to) {
                let along = match self.depth_kind {
                    DepthKind::Distance => 1.0,
                    DepthKind::Z => cosine(camera, [x, y]),
                };
                *to = (depth * self.scale * along).to_ne_bytes();
            }
        }
    }

    fn turned(&self, y: u32) -> u32 {
        self.upside_down.map_or(y, |rows| rows - 1 - y)
    }

    fn write_row(&self, row: &[[f32; 4]], to: &mut [u8]) {
        let shown = |rgba: &[f32; 4]| match self.alpha {
            Alpha::Background => {
                let [r, g, b] = pixel::over(*rgba, self.background);
                [r, g, b, 1.0]
            }
            Alpha::Premultiplied => *rgba,
            Alpha::Straight => pixel::straight(*rgba),
        };
        match self.format {
            Format::Rgba8 | Format::Bgra8 => {
                for (to, rgba) in to.as_chunks_mut::<4>().0.iter_mut().zip(row) {
                    *to = pixel::rgba8(shown(rgba), self.color_space);
                    if self.format == Format::Bgra8 {
                        to.swap(0, 2);
                    }
                }
            }
            Format::RgbaF32 => {
                let to = to.as_chunks_mut::<4>().0.as_chunks_mut::<4>().0;
                for (to, rgba) in to.iter_mut().zip(row) {
                    *to = shown(rgba).map(f32::to_ne_bytes);
                }
            }
        }
    }
}

/// The cosine of the angle between a pixel's ray and the viewing direction.
fn cosine(camera: &Camera, [x, y]: [u32; 2]) -> f32 {
    let slope = |a: usize, at: u32| (at as f32 + 0.5 - camera.center[a]) / camera.focal[a];
    let (x, y) = (slope(0, x), slope(1, y));
    1.0 / (1.0 + x * x + y * y).sqrt()
}
