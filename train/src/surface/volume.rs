//! Distances to the nearest surface, in a grid of voxels around it.

use glam::{UVec3, Vec3};
use rayon::prelude::*;

use super::Settings;
use super::look::Seen;

/// Lattice points along a side of a block.
pub(super) const SIDE: usize = 8;
/// And in it.
pub(super) const POINTS: usize = SIDE * SIDE * SIDE;
/// Distances are cut off so many voxels from a surface.
const CUT: f32 = 4.0;
/// A block that has none.
const NONE: u32 = u32::MAX;

/// Blocks of lattice points where surfaces are; none where all is empty or hidden.
#[derive(Debug)]
pub(super) struct Volume {
    min: Vec3,
    /// The distance between lattice points.
    voxel: f32,
    /// The outermost lattice point.
    last: UVec3,
    /// Along each axis.
    blocks: UVec3,
    /// The number of each block.
    index: Vec<u32>,
    pub(super) filled: Vec<Block>,
    /// What no camera sees is solid.
    solid: bool,
}

/// Lattice points, x fastest.
#[derive(Debug)]
pub(super) struct Block {
    /// The first one.
    pub(super) first: UVec3,
    /// In cut-offs, from −1 to 1; NaN where no camera has told.
    distance: Box<[f32; POINTS]>,
}

impl Volume {
    /// With blocks around what is seen, or all of them for a closed surface.
    pub(super) fn around(seen: &[Seen], [min, max]: [Vec3; 2], settings: &Settings) -> Self {
        let voxel = (max - min).max_element() / settings.resolution as f32;
        // One more on each side, for what is outside.
        let points = ((max - min) / voxel).ceil().as_uvec3() + 3;
        let blocks = (points + SIDE as u32 - 1) / SIDE as u32;
        let n = blocks.element_product() as usize;
        let solid = settings.watertight;
        let index = vec![NONE; n];
        let (min, last, filled) = (min - voxel, points - 1, Vec::new());
        let mut volume = Self { min, voxel, last, blocks, index, filled, solid };
        if solid {
            volume.index.fill(0);
        } else {
            seen.iter().for_each(|seen| volume.mark(seen));
        }
        for block in 0..n {
            if volume.index[block] != NONE {
                volume.index[block] = volume.filled.len() as u32;
                let first = volume.first_of(block);
                volume.filled.push(Block { first, distance: Box::new([f32::NAN; POINTS]) });
            }
        }
        volume
    }

    /// Marks the blocks within the cut-off of what a camera sees.
    fn mark(&mut self, seen: &Seen) {
        let cut = Vec3::splat(self.cut());
        let most = (self.blocks * SIDE as u32 - 1).as_vec3();
        for point in (0..seen.depth.len()).filter_map(|pixel| seen.point(pixel)) {
            let [low, high] =
                [point - cut, point + cut].map(|corner| (corner - self.min) / self.voxel);
            if high.min_element() < 0.0 || low.cmpgt(most).any() {
                continue;
            }
            let low = low.max(Vec3::ZERO).as_uvec3() / SIDE as u32;
            let high = high.min(most).as_uvec3() / SIDE as u32;
            for z in low.z..=high.z {
                for y in low.y..=high.y {
                    for x in low.x..=high.x {
                        let block = self.block(UVec3::new(x, y, z));
                        self.index[block] = 0;
                    }
                }
            }
        }
    }

    fn block(&self, at: UVec3) -> usize {
        ((at.z * self.blocks.y + at.y) * self.blocks.x + at.x) as usize
    }

    fn first_of(&self, block: usize) -> UVec3 {
        let (block, along) = (block as u32, self.blocks);
        let (x, y) = (block % along.x, block / along.x % along.y);
        UVec3::new(x, y, block / (along.x * along.y)) * SIDE as u32
    }

    /// Distances are cut off there, scene units.
    pub(super) fn cut(&self) -> f32 {
        CUT * self.voxel
    }

    /// The mean over all cameras of how far before (positive) or behind what they see each
    /// lattice point lies. What is far behind is hidden from a camera, which tells nothing of it.
    /// Nearer cameras see better, and count more.
    pub(super) fn fill(&mut self, seen: &[Seen]) {
        let (min, voxel, cut, solid) = (self.min, self.voxel, self.cut(), self.solid);
        let last = self.last;
        self.filled.par_iter_mut().for_each(|block| {
            for (i, distance) in block.distance.iter_mut().enumerate() {
                let at = block.first + offset(i);
                if solid && (at.cmpeq(UVec3::ZERO).any() || at.cmpge(last).any()) {
                    *distance = 1.0;
                    continue;
                }
                let point = min + voxel * at.as_vec3();
                let (mut sum, mut weights) = (0.0, 0.0);
                for seen in seen {
                    let Some((depth, _)) = seen.towards(point, cut) else { continue };
                    let away = point.distance(Vec3::from(seen.camera.position()));
                    let before = (depth - away) / cut;
                    if before >= -1.0 {
                        let weight = (seen.camera.focal[0] * voxel / away).powi(2);
                        sum += weight * before.min(1.0);
                        weights += weight;
                    }
                }
                *distance = match weights > 0.0 {
                    true => sum / weights,
                    false if solid => -1.0,
                    false => f32::NAN,
                };
            }
        });
    }

    /// The distance at a lattice point, in cut-offs; NaN where it is not known.
    pub(super) fn distance(&self, at: UVec3) -> f32 {
        let block = at / SIDE as u32;
        if block.cmpge(self.blocks).any() {
            return f32::NAN;
        }
        match self.index[self.block(block)] {
            NONE => f32::NAN,
            number => self.filled[number as usize].distance[place(at)],
        }
    }

    /// The number of the block in which this lattice point lies, and its place there.
    pub(super) fn place(&self, at: UVec3) -> Option<(usize, usize)> {
        let block = at / SIDE as u32;
        let number = self.index[self.block(block)];
        (number != NONE).then(|| (number as usize, place(at)))
    }

    /// A point of the lattice, or between, in scene units.
    pub(super) fn scene(&self, at: Vec3) -> Vec3 {
        self.min + self.voxel * at
    }
}

fn place(at: UVec3) -> usize {
    let within = (at % SIDE as u32).to_array().map(|x| x as usize);
    (within[2] * SIDE + within[1]) * SIDE + within[0]
}

/// From a block's first lattice point to this one.
pub(super) fn offset(place: usize) -> UVec3 {
    UVec3::new((place % SIDE) as u32, (place / SIDE % SIDE) as u32, (place / (SIDE * SIDE)) as u32)
}
