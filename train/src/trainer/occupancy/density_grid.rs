//! Which cells a field occupies, learnt while it trains.
//!
//! Every candidate cell keeps a decaying maximum of the densities seen at
//! random points in it (Müller et al. 2022, appendix C). A cell is occupied
//! where a step through it would absorb more than a little; the threshold is
//! held below the mean, so that a field that is thin everywhere is not lost.

use std::sync::OnceLock;

use fearless_simd::Level;
use pocketnerf_core::AnyField;
use pocketnerf_core::Occupancy;
use rayon::prelude::*;

use crate::pool::Pool;
use crate::probe::{BATCH, Probe};
use crate::random::Random;
use crate::trainer::occupancy::cells::{Grown, Packed};

/// A cell is sampled in one of so many updates.
pub(crate) const PERIOD: usize = 4;
/// What remains of a cell's density when it is sampled again, while the field
/// changes.
const DECAY: f32 = 0.8;
/// Optical thickness of one step above which a cell is occupied.
const THRESHOLD: f32 = 0.006;
/// Cells a task.
const TASK: usize = 512;

/// Decaying densities of the candidate cells, and the bits made from them.
#[derive(Clone, Debug, Default)]
pub struct DensityGrid {
    resolution: u32,
    /// Cells that may hold something, ascending; the rest never will.
    candidates: Vec<u32>,
    /// Greatest density of each candidate, 1 / scene unit.
    density: Vec<f32>,
    /// What remains of a density when its cell is sampled again.
    decay: f32,
    /// The occupied cells.
    occupied: Packed,
    /// The occupied cells and their neighbours, once they are asked for.
    grown: OnceLock<Packed>,
    updates: u32,
}

impl DensityGrid {
    /// All candidates occupied.
    #[must_use]
    pub fn new(resolution: u32, candidates: Vec<u32>) -> Self {
        let mut grid = Self {
            resolution,
            density: vec![f32::INFINITY; candidates.len()],
            decay: DECAY,
            candidates,
            occupied: Packed::default(),
            grown: OnceLock::new(),
            updates: 0,
        };
        grid.reset();
        grid
    }

    /// As it was when it was made: all candidates occupied.
    pub fn reset(&mut self) {
        self.density.fill(f32::INFINITY);
        self.updates = 0;
        self.occupied = Packed::of(self.resolution, self.candidates.iter().copied());
        self.grown = OnceLock::new();
    }

    /// The bits, for core to march through.
    #[must_use]
    pub fn view(&self) -> Occupancy<'_> {
        self.occupied.view()
    }

    /// The occupied cells and all their neighbours, candidates or not.
    #[must_use]
    pub fn grown(&self) -> Occupancy<'_> {
        self.neighbours().view()
    }

    fn neighbours(&self) -> &Packed {
        self.grown.get_or_init(|| {
            let near = Grown::new(&self.occupied.bare());
            Packed::of(self.resolution, near.cells())
        })
    }

    /// The bits alone, or those of the neighbours too: without the tables that core has.
    pub(crate) fn bare(&self, neighbours: bool) -> Occupancy<'_> {
        if neighbours { self.neighbours().bare() } else { self.occupied.bare() }
    }

    /// Fraction of the candidates that are occupied.
    #[must_use]
    pub fn fraction(&self) -> f32 {
        let all = f64::from(self.resolution).powi(3);
        (f64::from(self.view().fraction()) * all / self.candidates.len().max(1) as f64) as f32
    }

    /// Cells half as wide, where those of this grid are occupied, for a field that
    /// no longer changes: looks find the occupied among them.
    #[must_use]
    pub(crate) fn finer(&self) -> Self {
        let n = self.resolution;
        let view = self.view();
        let at = |cell: &&u32| view.cell(*cell % n, *cell / n % n, *cell / (n * n));
        self.halved(self.candidates.iter().filter(at).copied())
    }

    /// The same, where the occupied cells of this grid and their neighbours are.
    #[must_use]
    pub(crate) fn finer_and_around(&self) -> Self {
        let n = self.resolution;
        let view = self.grown();
        let at = |cell: &u32| view.cell(*cell % n, *cell / n % n, *cell / (n * n));
        self.halved((0..n * n * n).filter(at))
    }

    fn halved(&self, cells: impl Iterator<Item = u32>) -> Self {
        let (n, mut candidates) = (self.resolution, Vec::new());
        for cell in cells {
            let [x, y, z] = [cell % n, cell / n % n, cell / (n * n)];
            for (k, j, i) in (0..8).map(|c| (c >> 2, c >> 1 & 1, c & 1)) {
                candidates.push(((2 * z + k) * 2 * n + 2 * y + j) * 2 * n + 2 * x + i);
            }
        }
        candidates.sort_unstable();
        Self { decay: 1.0, ..Self::new(2 * n, candidates) }
    }

    /// The cells that are denser than `sigma`, 1 / scene unit.
    pub fn denser_than(&self, sigma: f32) -> impl Iterator<Item = u32> {
        let cells = self.candidates.iter().zip(&self.density);
        cells.filter(move |(_, density)| **density > sigma).map(|(cell, _)| *cell)
    }

    /// What a checkpoint keeps: densities and number of updates.
    #[must_use]
    pub fn state(&self) -> (&[f32], u32) {
        (&self.density, self.updates)
    }

    /// Takes back what [`DensityGrid::state`] gave, with the bits of
    /// [`DensityGrid::view`]. False where the sizes differ.
    #[must_use]
    pub fn restore(&mut self, density: &[f32], updates: u32, coarse: &[u8], fine: &[u8]) -> bool {
        let occupied = Packed::new(self.resolution, coarse.to_vec(), fine.to_vec());
        let (Ok(occupied), true) = (occupied, density.len() == self.density.len()) else {
            return false;
        };
        self.density.copy_from_slice(density);
        self.updates = updates;
        self.occupied = occupied;
        self.grown = OnceLock::new();
        true
    }

    /// Looks at a share of the candidates, one random point each. The bits stay as they
    /// are.
    pub(crate) fn look(
        &mut self,
        level: Level,
        field: &AnyField<'_>,
        seed: u64,
        probes: &Pool<Probe>,
        new: impl Fn() -> Probe + Sync,
    ) {
        let points = self.points(seed);
        let mut sigmas = vec![0.0; points.len()];
        points.par_chunks(TASK).zip(sigmas.par_chunks_mut(TASK)).for_each(|(points, sigmas)| {
            let mut probe = probes.take(&new);
            for (a, row) in probe.points().iter_mut().enumerate() {
                row.iter_mut().zip(points).for_each(|(to, point)| *to = point[a]);
            }
            sigmas.copy_from_slice(probe.densities(level, field, points.len()));
            probes.put(probe);
        });
        self.note(&sigmas);
    }

    /// The random points that are looked at next, in unit coordinates, for [`note`](Self::note) to
    /// take the densities there.
    pub(crate) fn points(&self, seed: u64) -> Vec<[f32; 3]> {
        let (n, update) = (self.resolution as usize, u64::from(self.updates));
        let phase = self.updates as usize % PERIOD;
        let tasks = self.candidates.par_chunks(TASK * PERIOD).enumerate();
        let points = tasks.flat_map_iter(|(task, cells)| {
            let mut random = Random::new(seed, [2, update, task as u64]);
            cells.iter().skip(phase).step_by(PERIOD).map(move |cell| {
                let cell = *cell as usize;
                let corner = [cell % n, cell / n % n, cell / (n * n)];
                corner.map(|c| (c as f32 + random.next_f32()) / n as f32)
            })
        });
        points.collect()
    }

    /// Takes the densities at the [points](Self::points) that were to be looked at next.
    pub(crate) fn note(&mut self, sigmas: &[f32]) {
        let phase = self.updates as usize % PERIOD;
        let first_look = self.updates < PERIOD as u32;
        let looked_at = self.density.iter_mut().skip(phase).step_by(PERIOD);
        for (density, sigma) in looked_at.zip(sigmas) {
            let before = if first_look { 0.0 } else { *density * self.decay };
            *density = before.max(*sigma);
        }
        self.updates += 1;
    }

    /// Updates the bits, once all candidates have been sampled. `step` is the distance
    /// between samples, scene units; a cell is occupied from `factor` times the usual thickness on.
    pub(crate) fn settle(&mut self, step: f32, factor: f32) {
        if self.updates >= PERIOD as u32 {
            self.occupied = self.above(step, factor);
            self.grown = OnceLock::new();
        }
    }

    /// The occupied cells.
    pub(crate) fn occupied(&self) -> &Packed {
        &self.occupied
    }

    /// The cells in which a step of this length, scene units, would absorb `factor`
    /// times what makes a cell occupied.
    pub(crate) fn above(&self, step: f32, factor: f32) -> Packed {
        let sum: f64 = self.density.iter().map(|d| f64::from(*d)).sum();
        let mean = (sum / self.density.len().max(1) as f64) as f32;
        let threshold = (factor * THRESHOLD / step).min(mean);
        let cells = self.candidates.iter().zip(&self.density);
        let occupied = cells.filter(|(_, density)| **density >= threshold);
        Packed::of(self.resolution, occupied.map(|(cell, _)| *cell))
    }
}

const _: () = assert!(TASK <= BATCH);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_by_hand() {
        let mut grid = DensityGrid::new(16, (0..8).collect());
        grid.density.copy_from_slice(&[0.01, 0.013, 0.04, 0.1, 2.0, 2.0, 2.0, 2.0]);
        // Steps of 0.5: the usual threshold is 0.012.
        let occupied = |grid: &DensityGrid, factor: f32| {
            (grid.above(0.5, factor).view().fraction() * 4096.0).round()
        };
        assert_eq!(
            [1.0, 3.0, 4.0, 10.0].map(|factor| occupied(&grid, factor)),
            [7.0, 6.0, 5.0, 4.0]
        );
        // Never above the mean, about 1: what is thin everywhere is not lost.
        assert_eq!(occupied(&grid, 1e6), 4.0);
        grid.density.fill(0.01);
        assert_eq!(occupied(&grid, 10.0), 8.0);
    }
}
