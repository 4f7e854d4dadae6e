//! A group's way back: samples with their gradients, sorted by the slab of the grid that they
//! change.

use std::sync::MutexGuard;

use pocketnerf_core::encoding::voxel_grid::BRICK_SIDE;
use pocketnerf_core::lanes::LANES;

use super::TrainablePlenoxels;
use super::bricks::{Bricks, SLABS};
use crate::field::{Back, Context, SampleGradients};
use crate::stopwatch::{Laps, Stage, Stopwatch};

/// What is kept of a sample: coordinates, direction, and the gradients of the logarithm of its
/// density and of its colour.
pub(super) const ROWS: usize = 3 + 3 + 1 + 3;

/// Samples in blocks of 16, `[ROWS][16]` each; the last is filled up with zeros.
#[derive(Debug, Default)]
pub(super) struct Samples {
    blocks: Vec<[[f32; LANES]; ROWS]>,
    len: usize,
}

impl Samples {
    fn push(&mut self, sample: [f32; ROWS]) {
        let (block, lane) = (self.len / LANES, self.len % LANES);
        if lane == 0 {
            if block == self.blocks.len() {
                self.blocks.push([[0.0; LANES]; ROWS]);
            } else {
                self.blocks[block] = [[0.0; LANES]; ROWS];
            }
        }
        for (row, value) in self.blocks[block].iter_mut().zip(sample) {
            row[lane] = value;
        }
        self.len += 1;
    }

    /// The blocks, each with its number of samples.
    pub(super) fn blocks(&self) -> impl Iterator<Item = (&[[f32; LANES]; ROWS], usize)> {
        let left = |block: usize| (self.len - block * LANES).min(LANES);
        let blocks = self.blocks[..self.len.div_ceil(LANES)].iter().enumerate();
        blocks.map(move |(number, block)| (block, left(number)))
    }
}

/// Gradients of a group of rays.
#[derive(Debug, Default)]
pub(super) struct GroupGradients {
    /// A sample between two slabs is in both.
    pub(super) slabs: [Samples; SLABS],
}

impl GroupGradients {
    /// None again.
    pub(super) fn clear(&mut self) {
        self.slabs.iter_mut().for_each(|samples| samples.len = 0);
    }
}

/// The way back.
#[derive(Debug)]
pub(super) struct PlenoxelsBack<'a> {
    resolution: f32,
    bricks: &'a Bricks,
    stopwatch: Option<&'a Stopwatch>,
    group: MutexGuard<'a, GroupGradients>,
}

impl<'a> PlenoxelsBack<'a> {
    pub(super) fn new(
        owner: &'a TrainablePlenoxels,
        group: MutexGuard<'a, GroupGradients>,
        context: Context<'a>,
    ) -> Self {
        let resolution = owner.config.resolution as f32;
        Self { resolution, bricks: &owner.bricks, stopwatch: context.stopwatch, group }
    }
}

impl Back for PlenoxelsBack<'_> {
    fn samples(&mut self, samples: &SampleGradients<'_>) {
        let mut laps = Laps::begin(self.stopwatch);
        let rows = samples.gradients.chunks_exact(samples.row_len);
        for (i, row) in rows.enumerate().take(samples.len) {
            let ([x, y, z], [dx, dy, dz]) =
                (samples.points.map(|axis| axis[i]), samples.directions.map(|axis| axis[i]));
            // A colour that is cut off is changed by what brings it back.
            let of_color = |c: usize| match samples.colors[c][i] {
                color if color <= 0.0 => row[1 + c].min(0.0),
                color if color >= 1.0 => row[1 + c].max(0.0),
                _ => row[1 + c],
            };
            let sample = [x, y, z, dx, dy, dz, row[0], of_color(0), of_color(1), of_color(2)];
            // As the grid finds the voxel.
            let voxel = (z.clamp(0.0, 1.0) * self.resolution) as u32;
            let slab = |corner: u32| self.bricks.slab_of_layer((corner / BRICK_SIDE) as usize);
            let [low, high] = [slab(voxel), slab(voxel + 1)];
            self.group.slabs[low].push(sample);
            if high != low {
                self.group.slabs[high].push(sample);
            }
        }
        laps.end(Stage::Backward, samples.len);
    }
}
