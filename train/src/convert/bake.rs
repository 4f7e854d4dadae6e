//! The occupied cells of an imported field, so that rendering can skip the others.
//!
//! These networks were not trained to be empty anywhere. So a cell counts as empty only if
//! many points in it and in all its neighbours hold almost nothing.

use crate::pool::Pool;
use crate::probe::Probe;
use crate::trainer::{DensityGrid, all_cells};
use fearless_simd::Level;
use pocketnerf_core::{AnyField, Space};

/// Cells along an axis in the first search.
const COARSE: u32 = 64;
/// Random points that are evaluated per cell.
const LOOKS: usize = 8;

/// Finds the occupied cells of a field.
#[derive(Debug)]
pub(super) struct Baker<'f> {
    pub(super) field: &'f AnyField<'f>,
    pub(super) level: Level,
    pub(super) seed: u64,
    /// Distance between samples, local units.
    pub(super) step: f32,
}

impl Baker<'_> {
    /// The occupied cells of the space and all their neighbours, at twice the resolution of
    /// the first search.
    pub(super) fn cells(&self, space: &Space) -> DensityGrid {
        let mut coarse = DensityGrid::new(COARSE, all_cells(space, COARSE));
        self.look(&mut coarse);
        let mut fine = coarse.finer_and_around();
        self.look(&mut fine);
        fine
    }

    /// The corners of what is occupied, and a cell more on every side; unit coordinates.
    pub(super) fn bounds(&self, space: &Space) -> Option<[[f32; 3]; 2]> {
        let mut grid = DensityGrid::new(COARSE, all_cells(space, COARSE));
        self.look(&mut grid);
        let n = COARSE;
        let (mut low, mut high) = ([n; 3], [0; 3]);
        let view = grid.view();
        for cell in 0..n * n * n {
            let cell = [cell % n, cell / n % n, cell / (n * n)];
            if view.cell(cell[0], cell[1], cell[2]) {
                for a in 0..3 {
                    low[a] = low[a].min(cell[a]);
                    high[a] = high[a].max(cell[a] + 1);
                }
            }
        }
        let side = 1.0 / n as f32;
        let corners = [
            low.map(|cell| cell.saturating_sub(1) as f32 * side),
            high.map(|cell| (cell + 1).min(n) as f32 * side),
        ];
        (low[0] < high[0]).then_some(corners)
    }

    fn look(&self, grid: &mut DensityGrid) {
        let probes = Pool::default();
        let limits = self.field.limits();
        for _ in 0..LOOKS * crate::trainer::OCCUPANCY_PERIOD {
            let new = || Probe::new(limits);
            grid.look(self.level, self.field, self.seed, &probes, new);
        }
        grid.settle(self.step, 1.0);
    }
}
