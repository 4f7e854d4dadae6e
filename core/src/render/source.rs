//! Where the rays of a picture come from.

use fearless_simd::{Simd, SimdBase};

use crate::camera::{Camera, Ray};
use crate::march::{LANES, RayPacket};
use crate::render::Tile;
use crate::render::foreground::Foreground;
use crate::{Error, Model};

/// Rays by their number.
pub(super) trait Source {
    /// Width and height of the picture that they make, pixels.
    fn size(&self) -> Result<[u32; 2], Error>;

    /// Puts the rays of these numbers, at most sixteen, into the packet's first
    /// lanes, to be sampled in the middle of their steps.
    fn fill<S: Simd>(&self, simd: S, numbers: &[u32], packet: &mut RayPacket);

    /// The ray of a number.
    fn ray(&self, number: u32) -> Ray;

    /// Where the camera that they come from looks, a unit vector.
    fn axis(&self) -> Option<[f32; 3]>;

    /// What the rays see, every `spacing`-th along both axes; `depths` is its memory.
    fn foreground<'s>(
        &self,
        model: &Model<'_>,
        spacing: u32,
        depths: &'s mut [f32],
    ) -> Foreground<'s>;

    /// Rays that lie side by side and meet the narrowest of the model's cells.
    fn cell(&self, model: &Model<'_>) -> f32;
}

impl Source for [Ray] {
    /// A row.
    fn size(&self) -> Result<[u32; 2], Error> {
        let n = u32::try_from(self.len()).map_err(|_| Error::Range("number of rays"))?;
        Ok([n, 1])
    }

    #[inline(always)]
    fn fill<S: Simd>(&self, _: S, numbers: &[u32], packet: &mut RayPacket) {
        for (lane, number) in numbers.iter().enumerate() {
            packet.set(lane, &self[*number as usize], 0.5);
        }
    }

    fn ray(&self, number: u32) -> Ray {
        self[number as usize]
    }

    /// They need not come from a camera.
    fn axis(&self) -> Option<[f32; 3]> {
        None
    }

    /// Nothing is known of where they go.
    fn foreground<'s>(&self, _: &Model<'_>, _: u32, depths: &'s mut [f32]) -> Foreground<'s> {
        Foreground::unknown(depths)
    }

    /// Nothing is known of how they lie.
    fn cell(&self, _: &Model<'_>) -> f32 {
        0.0
    }
}

/// The pixels of a tile, row after row.
pub(super) struct Pixels<'c> {
    pub(super) camera: &'c Camera,
    pub(super) tile: Tile,
}

impl Source for Pixels<'_> {
    fn size(&self) -> Result<[u32; 2], Error> {
        let Tile { width, height, .. } = self.tile;
        // Pixels are numbered.
        let n = width.checked_mul(height).ok_or(Error::Range("pixels of a tile"));
        n.map(|_| [width, height])
    }

    #[inline(always)]
    fn fill<S: Simd>(&self, simd: S, numbers: &[u32], packet: &mut RayPacket) {
        let Tile { x, y, width, .. } = self.tile;
        let [mut columns, mut rows] = [[0.5; LANES]; 2];
        for ((column, row), number) in columns.iter_mut().zip(&mut rows).zip(numbers) {
            *column = x.saturating_add(number % width) as f32 + 0.5;
            *row = y.saturating_add(number / width) as f32 + 0.5;
        }
        simd.vectorize(
            #[inline(always)]
            || {
                let n = S::f32s::LEN;
                for lane in (0..LANES).step_by(n) {
                    let at = |row: &[f32; LANES]| S::f32s::from_slice(simd, &row[lane..lane + n]);
                    let directions = self.camera.directions(simd, at(&columns), at(&rows));
                    for (to, direction) in packet.direction.iter_mut().zip(directions) {
                        direction.store_slice(&mut to[lane..lane + n]);
                    }
                }
            },
        );
        packet.origin = self.camera.position().map(|o| [o; LANES]);
        packet.phase = [0.5; LANES];
    }

    fn ray(&self, number: u32) -> Ray {
        let Tile { x, y, width, .. } = self.tile;
        let at = |first: u32, more: u32| first.saturating_add(more) as f32 + 0.5;
        self.camera.ray(at(x, number % width), at(y, number / width))
    }

    fn axis(&self) -> Option<[f32; 3]> {
        Some(self.camera.axis())
    }

    fn foreground<'s>(
        &self,
        model: &Model<'_>,
        spacing: u32,
        depths: &'s mut [f32],
    ) -> Foreground<'s> {
        Foreground::of(model, self.camera, self.tile, spacing, depths)
    }

    /// Pixels that a cell spans at the far end of a box. Elsewhere there may be none.
    fn cell(&self, model: &Model<'_>) -> f32 {
        let (Some(occupancy), Some([min, max])) = (model.occupancy, model.space.scene_box()) else {
            return 0.0;
        };
        let eye = self.camera.position();
        let farthest = |a: usize| (eye[a] - min[a]).abs().max((max[a] - eye[a]).abs());
        let [x, y, z] = [farthest(0), farthest(1), farthest(2)];
        let distance = crate::math::sqrt(x * x + y * y + z * z);
        let side = 1.0 / (model.space.unit_map().scale * occupancy.resolution() as f32);
        side * self.camera.focal[0].abs().min(self.camera.focal[1].abs()) / distance
    }
}
