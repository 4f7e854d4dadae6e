//! A step of all values that samples read: each slab of the grid by itself, so that its gradients
//! stay in the cache.

use std::ops::Range;
use std::sync::PoisonError;

#[cfg(test)]
use fearless_simd::Level;
use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch};
use pocketnerf_core::encoding::VoxelGrid;
use pocketnerf_core::encoding::hash_grid::Corners;
use pocketnerf_core::encoding::spherical_harmonics;
use pocketnerf_core::encoding::voxel_grid::BRICK;
use pocketnerf_core::field::PlenoxelField;
use pocketnerf_core::lanes::LANES;
use rayon::prelude::*;

use super::TrainablePlenoxels;
use super::back::{GroupGradients, ROWS};
use super::bricks::{Bricks, SLABS};
use crate::aligned::Aligned;
use crate::field::Update;
use crate::field::rounding::EightBits;
use crate::stopwatch::{Laps, Stage};
use crate::trainer::{Adam, Slices};

/// Weight of the differences between neighbours: lego, val views, see docs/lab/plenoxels.md.
const SMOOTHNESS: f32 = 1e-4;

/// The values of a slab, and all that belongs to them.
struct Slab<'p> {
    number: usize,
    /// Its rows of the grid.
    rows: Range<usize>,
    parameters: &'p mut [f32],
    /// Second moments.
    square: &'p mut [f32],
    /// The parameters, rounded.
    rounded: &'p mut [u8],
}

/// Gradients of a slab, and which rows have any.
struct Gradients<'g> {
    rows: Range<usize>,
    values: &'g mut [f32],
    /// A bit a row.
    touched: &'g mut [u64],
}

/// How values change.
#[derive(Clone, Copy)]
struct Rates {
    adam: Adam,
    rate: f32,
    rounding: EightBits,
}

impl TrainablePlenoxels {
    pub(super) fn update_parameters(&mut self, update: Update<'_>) {
        let Update { level, parameters, square, step, stopwatch, .. } = update;
        let adam = Adam { beta1: 0.0, decay: update.table_decay, ..update.adam };
        let rate = adam.corrected(update.table_rate, step);
        let rates = Rates { adam, rate, rounding: self.rounded.scales[0] };
        let (n_values, bricks) = (self.config.n_values(), &self.bricks);
        // The brick that holds nothing stays as it is.
        let held = BRICK * n_values;
        let mut rest =
            (&mut parameters[held..], &mut square[held..], &mut self.rounded.tables[held..]);
        let slabs: Vec<Slab<'_>> = (0..SLABS)
            .map(|number| {
                let bricks = bricks.slab(number);
                let rows = BRICK * bricks.start..BRICK * bricks.end;
                let len = n_values * rows.len();
                Slab {
                    number,
                    rows,
                    parameters: rest.0.split_off_mut(..len).unwrap_or_default(),
                    square: rest.1.split_off_mut(..len).unwrap_or_default(),
                    rounded: rest.2.split_off_mut(..len).unwrap_or_default(),
                }
            })
            .collect();
        let groups: Vec<&GroupGradients> = self
            .groups
            .iter_mut()
            .map(|group| &*group.get_mut().unwrap_or_else(PoisonError::into_inner))
            .collect();
        let most = (0..SLABS).map(|slab| bricks.slab(slab).len() * BRICK).max().unwrap_or(0);
        let view = self.config.view(bricks, 0.0, EMPTY).expect("checked when training began");
        let (grid, sh_degree) = (view.grid, view.sh_degree);
        let update_slab = |slab: Slab<'_>| {
            let mut laps = Laps::begin(stopwatch);
            // The step leaves the buffer zeroed.
            let mut buffer = self.slab_gradients.lease(|| Aligned::new(most * n_values));
            let mut touched = vec![0; slab.rows.len().div_ceil(64)];
            let mut gradients = Gradients {
                rows: slab.rows.clone(),
                values: &mut buffer[..slab.parameters.len()],
                touched: &mut touched,
            };
            let largest = dispatch!(level, simd => {
                for group in &groups {
                    let samples = &group.slabs[slab.number];
                    scatter(simd, (&grid, sh_degree), samples.blocks(), &mut gradients);
                }
                laps.end(Stage::Scatter, 0);
                smooth(bricks, n_values, &mut gradients, &slab);
                follow(simd, rates, n_values, gradients, slab)
            });
            laps.end(Stage::Adam, 0);
            largest
        };
        let largest = slabs.into_par_iter().with_max_len(1).map(update_slab);
        let largest = largest.reduce(|| 0.0, f32::max);
        let rounded = &mut self.rounded;
        if rounded.scales[0].hold(largest) {
            let scales = rounded.scales.clone();
            rounded.round_tables(level, &self.layout, &scales, parameters);
        }
    }

    /// The groups' gradients, summed up as the update would see them.
    #[cfg(test)]
    pub(super) fn summed(&self, level: Level) -> Vec<f32> {
        let n_values = self.config.n_values();
        let mut sum = vec![0.0; self.layout.len()];
        let view = self.config.view(&self.bricks, 0.0, EMPTY).unwrap();
        let grid = (&view.grid, view.sh_degree);
        for number in 0..SLABS {
            let bricks = self.bricks.slab(number);
            let rows = BRICK * bricks.start..BRICK * bricks.end;
            let mut touched = vec![0; rows.len().div_ceil(64)];
            for group in &self.groups {
                let group = group.lock().unwrap();
                let mut gradients = Gradients {
                    rows: rows.clone(),
                    values: &mut sum[n_values * rows.start..n_values * rows.end],
                    touched: &mut touched,
                };
                let blocks = || group.slabs[number].blocks();
                dispatch!(level, simd => scatter(simd, grid, blocks(), &mut gradients));
            }
        }
        sum
    }
}

/// A grid's places need no values.
const EMPTY: pocketnerf_core::TensorView<'static> = pocketnerf_core::TensorView::EMPTY;

/// Adds the gradients of samples to the rows of a slab that they read.
#[inline(always)]
fn scatter<'s, S: Simd>(
    simd: S,
    (grid, sh_degree): (&VoxelGrid<'_>, u32),
    blocks: impl Iterator<Item = (&'s [[f32; LANES]; ROWS], usize)>,
    gradients: &mut Gradients<'_>,
) {
    match sh_degree {
        1 => scatter_rows::<S, 4>(simd, (grid, sh_degree), blocks, gradients),
        2 => scatter_rows::<S, 16>(simd, (grid, sh_degree), blocks, gradients),
        _ => scatter_rows::<S, 32>(simd, (grid, sh_degree), blocks, gradients),
    }
}

#[inline(always)]
fn scatter_rows<'s, S: Simd, const V: usize>(
    simd: S,
    (grid, sh_degree): (&VoxelGrid<'_>, u32),
    blocks: impl Iterator<Item = (&'s [[f32; LANES]; ROWS], usize)>,
    gradients: &mut Gradients<'_>,
) {
    let Gradients { rows, values, touched } = gradients;
    let values = values.as_chunks_mut::<V>().0;
    let n = spherical_harmonics::n_output(sh_degree);
    let mut corners = Corners::ZERO;
    for (block, len) in blocks {
        let [x, y, z, dx, dy, dz, log_density, red, green, blue] = block;
        grid.place(simd, [x, y, z], 1.0, &mut corners);
        for s in 0..len {
            let mut harmonics = [0.0; 9];
            spherical_harmonics::evaluate(sh_degree, [dx[s], dy[s], dz[s]], &mut harmonics);
            let mut gradient = [0.0; V];
            gradient[0] = PlenoxelField::DENSITY_GAIN * log_density[s];
            for (color, d) in [red[s], green[s], blue[s]].into_iter().enumerate() {
                let own = gradient[1 + color * n..][..n].iter_mut();
                own.zip(harmonics).for_each(|(value, harmonic)| *value = d * harmonic);
            }
            for c in 0..8 {
                // Of other slabs, or of the brick that holds nothing: far beyond the last row.
                let row = (corners.entry[c][s] as usize).wrapping_sub(rows.start);
                let Some(to) = values.get_mut(row) else { continue };
                touched[row / 64] |= 1 << (row % 64);
                add(simd, corners.weight[c][s], &gradient, to);
            }
        }
    }
}

/// `to += weight * gradient`.
#[inline(always)]
fn add<S: Simd, const V: usize>(simd: S, weight: f32, gradient: &[f32; V], to: &mut [f32; V]) {
    if V < LANES {
        to.iter_mut().zip(gradient).for_each(|(to, g)| *to += weight * g);
        return;
    }
    let weight = S::f32s::splat(simd, weight);
    let lanes = gradient.chunks_exact(S::f32s::LEN);
    for (to, gradient) in to.chunks_exact_mut(S::f32s::LEN).zip(lanes) {
        let gradient = S::f32s::from_slice(simd, gradient);
        gradient.mul_add(weight, S::f32s::from_slice(simd, to)).store_slice(to);
    }
}

/// Adds what holds the values of rows that have a gradient to those of their neighbours, as
/// Plenoxels' total variation does: half the sum of squared differences, weighed.
fn smooth(bricks: &Bricks, n_values: usize, gradients: &mut Gradients<'_>, slab: &Slab<'_>) {
    for (word, touched) in gradients.touched.iter().enumerate() {
        let mut left = *touched;
        while left != 0 {
            let row = 64 * word + left.trailing_zeros() as usize;
            left &= left - 1;
            let gradient = &mut gradients.values[row * n_values..][..n_values];
            let own = &slab.parameters[row * n_values..][..n_values];
            for axis in 0..3 {
                // Other slabs are another thread's.
                let beside = bricks.rows_beside(row + slab.rows.start, axis).into_iter().flatten();
                for beside in beside.filter(|beside| slab.rows.contains(beside)) {
                    let beside = (beside - slab.rows.start) * n_values;
                    let beside = &slab.parameters[beside..][..n_values];
                    for (gradient, (own, beside)) in gradient.iter_mut().zip(own.iter().zip(beside))
                    {
                        *gradient += SMOOTHNESS * (own - beside);
                    }
                }
            }
        }
    }
}

/// A step of all rows that have a gradient, which becomes 0. Gives the largest magnitude that any
/// of their values has now.
#[inline(always)]
fn follow<S: Simd>(
    simd: S,
    Rates { adam, rate, rounding }: Rates,
    n_values: usize,
    gradients: Gradients<'_>,
    slab: Slab<'_>,
) -> f32 {
    let mut largest = 0.0f32;
    for (word, touched) in gradients.touched.iter().enumerate() {
        let mut left = *touched;
        while left != 0 {
            let row = 64 * word + left.trailing_zeros() as usize;
            left &= left - 1;
            let values = row * n_values..(row + 1) * n_values;
            let slices = Slices {
                parameters: &mut slab.parameters[values.clone()],
                gradient: &mut gradients.values[values.clone()],
                mean: &mut [],
                square: &mut slab.square[values.clone()],
                rounded: &mut slab.rounded[values],
            };
            largest = largest.max(adam.update(simd, rate, rounding, slices));
        }
    }
    largest
}
