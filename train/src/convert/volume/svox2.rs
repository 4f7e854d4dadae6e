//! Rays through a grid of svox2, as `SparseGrid.volume_render` renders them.

use pocketnerf_core::encoding::spherical_harmonics;
use pocketnerf_core::{Ray, Space};
use pocketnerf_formats::import::volume::Svox2;

use super::factors::between;
use super::{LEAST_LIGHT, Volume};

/// Voxels of a step.
const STEP: f32 = 0.5;
/// Voxels along an axis of a block that is skipped where none of its corners holds anything.
const BLOCK: usize = 8;
/// Values of a corner at most: a density and nine harmonics of each colour.
const MOST: usize = 28;

/// A grid, and which of its blocks hold nothing.
#[derive(Debug)]
pub(super) struct Voxels {
    pub(super) grid: Svox2,
    blocks: [usize; 3],
    pub(super) filled: Vec<bool>,
}

impl Voxels {
    pub(super) fn new(grid: Svox2) -> Self {
        let sizes = grid.sizes;
        let blocks = sizes.map(|n| (n - 1).div_ceil(BLOCK));
        let mut filled = vec![false; blocks.iter().product()];
        for (i, link) in grid.links.iter().enumerate() {
            if *link < 0 {
                continue;
            }
            let corner = [i / (sizes[1] * sizes[2]), i / sizes[2] % sizes[1], i % sizes[2]];
            // Those on a face are corners of two blocks.
            let [x, y, z] = [0, 1, 2].map(|a| {
                let first = corner[a].saturating_sub(1) / BLOCK;
                first..=(corner[a] / BLOCK).min(blocks[a] - 1)
            });
            for x in x {
                for y in y.clone() {
                    for z in z.clone() {
                        filled[(x * blocks[1] + y) * blocks[2] + z] = true;
                    }
                }
            }
        }
        Self { grid, blocks, filled }
    }

    /// The block around a voxel, in voxels, if it holds nothing.
    fn empty(&self, voxel: [usize; 3]) -> Option<Space> {
        let block = voxel.map(|v| v / BLOCK);
        let number = (block[0] * self.blocks[1] + block[1]) * self.blocks[2] + block[2];
        let min = block.map(|b| (b * BLOCK) as f32);
        (!self.filled[number]).then(|| Space::Box { min, max: min.map(|low| low + BLOCK as f32) })
    }

    /// Values at a place between corners: the density, then harmonics.
    fn values(&self, place: [(usize, f32); 3], values: &mut [f32]) {
        let Svox2 { sizes, links, densities, harmonics, .. } = &self.grid;
        values.fill(0.0);
        let n = values.len() - 1;
        for c in 0..8 {
            let side = |a: usize| c >> a & 1;
            let [x, y, z] = [0, 1, 2].map(|a| place[a].0 + side(a));
            let weights = [0, 1, 2].map(|a| match side(a) {
                0 => 1.0 - place[a].1,
                _ => place[a].1,
            });
            let link = links[(x * sizes[1] + y) * sizes[2] + z];
            let Ok(row) = usize::try_from(link) else { continue };
            let weight = weights[0] * weights[1] * weights[2];
            values[0] += weight * densities[row];
            let row = &harmonics[row * n..][..n];
            values[1..].iter_mut().zip(row).for_each(|(to, value)| *to += weight * value.to_f32());
        }
    }

    fn color(&self, ray: &Ray, samples: &mut u64) -> [f32; 4] {
        let Svox2 { center, radius, sizes, n_harmonics, .. } = self.grid;
        let voxels = sizes.map(|n| n as f32);
        let scaling = [0, 1, 2].map(|a| 0.5 * voxels[a] / radius[a]);
        let origin = [0, 1, 2].map(|a| {
            let middle = 0.5 * (1.0 - center[a] / radius[a]) * voxels[a] - 0.5;
            middle + ray.origin[a] * scaling[a]
        });
        let scaled = [0, 1, 2].map(|a| ray.direction[a] * scaling[a]);
        // Units of length of a voxel along the ray.
        let unit = 1.0 / scaled.iter().map(|v| v * v).sum::<f32>().sqrt();
        let in_voxels = Ray { origin, direction: scaled.map(|v| v * unit) };
        let whole = Space::Box { min: [-0.5; 3], max: voxels.map(|n| n - 0.5) };
        let Some([enter, leave]) = whole.intersect(&in_voxels, 0.0, f32::INFINITY) else {
            return [0.0; 4];
        };
        let mut harmonics = [0.0; 9];
        let degree = n_harmonics.isqrt() as u32;
        spherical_harmonics::evaluate(degree, ray.direction, &mut harmonics[..n_harmonics]);
        let mut values = [0.0; MOST];
        let values = &mut values[..=3 * n_harmonics];

        let (mut light, mut color) = (1.0f32, [0.0f32; 3]);
        let n_steps = ((leave - enter) / STEP) as usize + 1;
        let mut step = 0;
        while step < n_steps && light >= LEAST_LIGHT {
            let t = enter + step as f32 * STEP;
            let place = [0, 1, 2].map(|a| {
                let position = in_voxels.origin[a] + t * in_voxels.direction[a];
                between(position.min(voxels[a] - 1.0), sizes[a])
            });
            if let Some(block) = self.empty(place.map(|(voxel, _)| voxel)) {
                let end = block.intersect(&in_voxels, t, leave).map_or(t, |[_, end]| end);
                step += (((end - t) / STEP).ceil() as usize).max(1);
                continue;
            }
            step += 1;
            *samples += 1;
            self.values(place, values);
            let through = (-STEP * values[0].max(0.0) * unit).exp();
            let weight = light * (1.0 - through);
            for (color, of) in color.iter_mut().zip(values[1..].chunks_exact(n_harmonics)) {
                let sum: f32 = of.iter().zip(&harmonics).map(|(value, h)| value * h).sum();
                *color += weight * (0.5 + sum).max(0.0);
            }
            light *= through;
        }
        let [r, g, b] = color;
        [r, g, b, 1.0 - light]
    }
}

impl Volume for Voxels {
    fn trace(&self, rays: &[Ray], pixels: &mut [[f32; 4]]) -> u64 {
        let mut samples = 0;
        for (ray, pixel) in rays.iter().zip(pixels) {
            *pixel = self.color(ray, &mut samples);
        }
        samples
    }
}
