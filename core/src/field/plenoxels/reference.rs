//! Plenoxels, corner by corner, from the texts of [`crate::encoding::voxel_grid`] and
//! [`PlenoxelField`].

use crate::encoding::VoxelGrid;
use crate::field::{Features, MAX_CHANNELS, PlenoxelField, ReferenceField};
use crate::reference::harmonics::harmonics;
use crate::reference::math::exp;

/// Highest log density.
const MAX_LOG_DENSITY: f64 = 15.0;
/// Values of a corner that are read, at most.
const MAX_READ: usize = 1 + 3 * PlenoxelField::MAX_SH_DEGREE.pow(2) as usize;

impl ReferenceField for PlenoxelField<'_> {
    fn reference(&self, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
        let values = interpolated(&self.grid, u);
        let log = values[0] * f64::from(Self::DENSITY_GAIN) + f64::from(self.log_density_bias);
        let sigma = if log.is_nan() { 0.0 } else { exp(log.min(MAX_LOG_DENSITY)) };
        let n = (self.sh_degree * self.sh_degree) as usize;
        let harmonics = harmonics(self.sh_degree, direction);
        let mut channels = [0.0; MAX_CHANNELS];
        for (color, channel) in channels[..3].iter_mut().enumerate() {
            let own = &values[1 + color * n..][..n];
            let sum: f64 = own.iter().zip(harmonics).map(|(value, h)| value * h).sum();
            *channel = if sum.is_nan() { 0.0 } else { (0.5 + sum).clamp(0.0, 1.0) };
        }
        (sigma, channels)
    }
}

/// All values at unit point `u`.
fn interpolated(grid: &VoxelGrid<'_>, u: [f32; 3]) -> [f64; MAX_READ] {
    let position = u.map(|v| f64::from(v).clamp(0.0, 1.0) * f64::from(grid.resolution));
    let cell = position.map(|v| v as usize);
    let along = grid.resolution as usize / 4 + 1;
    let n_bricks = grid.values.rows() / 64;
    let mut out = [0.0; MAX_READ];
    for corner in 0..8 {
        let mut weight = 1.0;
        let mut c = cell;
        for axis in 0..3 {
            let fraction = position[axis] - cell[axis] as f64;
            let far_side = corner >> axis & 1;
            c[axis] += far_side;
            weight *= if far_side == 1 { fraction } else { 1.0 - fraction };
        }
        let [x, y, z] = c;
        let place = x / 4 + along * (y / 4 + along * (z / 4));
        let brick = (grid.index.get(place) as usize).min(n_bricks - 1);
        let row = 64 * brick + x % 4 + 4 * (y % 4) + 16 * (z % 4);
        for (v, out) in out.iter_mut().enumerate().take(grid.n_values()) {
            *out += weight * f64::from(grid.values.get(row * grid.n_values() + v));
        }
    }
    out
}
