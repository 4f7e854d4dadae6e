//! The shape of a grid of voxels, and when it becomes finer.

use std::sync::Arc;

use pocketnerf_core::encoding::{VoxelGrid, voxel_grid};
use pocketnerf_core::field::PlenoxelField;
use pocketnerf_core::{AnyField, DType, Error, Layout as Order, Occupancy, TensorView};

use super::bricks::Bricks;
use crate::field::Unusable;
use crate::field::layout::{Layout, Part, Role};

/// Name of the only part.
const VOXELS: &str = "voxels";
/// Share of a run after which the grid has its last resolution.
const GROWN_BY: f32 = 0.3;
/// The fewest voxels that training begins with, unless it ends with fewer.
const FEWEST: u32 = 128;

/// A sparse grid of voxels, without networks.
#[derive(Clone, Debug, PartialEq)]
pub struct PlenoxelsConfig {
    /// Voxels along the longest side of the scene now: a multiple of 4.
    pub resolution: u32,
    /// In the end: as asked for, or less where these are too many.
    pub last_resolution: u32,
    /// What was asked for.
    pub(super) asked: u32,
    /// Degree of the spherical harmonics, 1 to 3; 1 is independent of the view.
    pub sh_degree: u32,
    /// Which bricks are kept; `None`: all, or those that training chooses when it begins.
    pub(super) bricks: Option<Arc<Bricks>>,
}

impl Default for PlenoxelsConfig {
    fn default() -> Self {
        Self::new(256, 2)
    }
}

impl PlenoxelsConfig {
    /// A grid that ends with so many voxels along the longest side of the scene, a multiple of 4,
    /// and so many bands of harmonics. It begins with half as many or a quarter, but no fewer than 128.
    #[must_use]
    pub fn new(last_resolution: u32, sh_degree: u32) -> Self {
        let resolution = last_resolution >> stages(last_resolution);
        Self { resolution, last_resolution, asked: last_resolution, sh_degree, bricks: None }
    }

    /// The shape of a model's field, with what a checkpoint adds to it.
    pub(in crate::field) fn restored(
        field: &PlenoxelField<'_>,
        section: Option<&[u8]>,
    ) -> Result<Self, Unusable> {
        let resolution = field.grid.resolution;
        let section = section.ok_or(Unusable::NoSection)?.as_chunks::<4>();
        let &([last_resolution, asked], []) = &section else { return Err(Unusable::Section) };
        let [last_resolution, asked] = [*last_resolution, *asked].map(u32::from_le_bytes);
        let n_bricks = field.grid.values.rows() / voxel_grid::BRICK;
        let bricks = Bricks::read(field.grid.index.bytes(), resolution, n_bricks);
        let bricks = bricks.ok_or(Unusable::Model("voxels that are not numbered row after row"))?;
        let sh_degree = field.sh_degree;
        let bricks = Some(bricks.into());
        let config = Self { resolution, last_resolution, asked, sh_degree, bricks };
        config.check().map_err(|_| Unusable::Section)?;
        Ok(config)
    }

    /// What [`restored`](Self::restored) reads.
    pub(super) fn section(&self) -> Vec<u8> {
        [self.last_resolution, self.asked].map(u32::to_le_bytes).as_flattened().to_vec()
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        let sound = |n: u32| {
            n.is_multiple_of(voxel_grid::BRICK_SIDE)
                && (voxel_grid::BRICK_SIDE..=voxel_grid::MAX_RESOLUTION).contains(&n)
        };
        if ![self.resolution, self.last_resolution, self.asked].into_iter().all(sound) {
            return Err(Error::Range("voxel grid resolution: a multiple of 4, from 4 to 512"));
        }
        if !(1..=PlenoxelField::MAX_SH_DEGREE).contains(&self.sh_degree) {
            return Err(Error::Range("degree of the spherical harmonics"));
        }
        Ok(())
    }

    /// With the bricks that these cells touch; coarser where these are too many.
    pub(super) fn within(&self, cells: &Occupancy<'_>) -> Self {
        let Self { mut resolution, mut last_resolution, asked, sh_degree, .. } = *self;
        loop {
            if let Some(bricks) = Bricks::around(cells, resolution) {
                let bricks = Some(Arc::new(bricks));
                return Self { resolution, last_resolution, asked, sh_degree, bricks };
            }
            // All bricks of 144 voxels fit.
            resolution = (resolution / 5 * 4).max(144) / 16 * 16;
            last_resolution = resolution;
        }
    }

    /// What the grid is to be when so much of a run is over, if that is finer than it is.
    pub(super) fn due(&self, progress: f32) -> Option<Self> {
        let stages = stages(self.last_resolution);
        let left = stages.saturating_sub((progress / GROWN_BY * stages as f32) as u32);
        let resolution = self.last_resolution >> left;
        (resolution > self.resolution).then(|| Self { resolution, bricks: None, ..self.clone() })
    }

    /// Values of a corner.
    pub(super) const fn n_values(&self) -> usize {
        PlenoxelField::n_values(self.sh_degree)
    }

    /// The bricks: all where nothing else is known.
    pub(super) fn bricks(&self) -> Arc<Bricks> {
        self.bricks.clone().unwrap_or_else(|| Bricks::all(self.resolution).into())
    }

    /// Where the values lie.
    #[must_use]
    pub fn layout(&self) -> Layout {
        let mut layout = Layout::default();
        let rows = voxel_grid::BRICK * self.bricks().len();
        let part = Part { network: VOXELS, layer: 0, role: Role::Table };
        layout.push(part, [rows, self.n_values()]);
        layout
    }

    /// The field of the values.
    pub(super) fn view<'a>(
        &self,
        bricks: &'a Bricks,
        log_density_bias: f32,
        values: TensorView<'a>,
    ) -> Result<PlenoxelField<'a>, Error> {
        let numbers = bricks.numbers();
        let shape = [numbers.len() as u32, 1];
        let bytes = bytemuck::must_cast_slice(numbers);
        let index = TensorView::new(bytes, DType::U16, shape, 0, Order::RowMajor)?;
        let grid = VoxelGrid { resolution: self.resolution, index, values };
        Ok(PlenoxelField { grid, sh_degree: self.sh_degree, log_density_bias })
    }
}

/// How often a grid that ends with so many voxels becomes twice as fine.
fn stages(last_resolution: u32) -> u32 {
    let halves = |stages: u32| last_resolution >> stages;
    (0..8).take_while(|n| halves(n + 1) >= FEWEST && halves(n + 1).is_multiple_of(4)).count() as u32
}

/// The parameters of a grid of another shape that holds the same scene: interpolated.
pub(super) fn carried_over(
    (old, from): (&PlenoxelsConfig, &[f32]),
    new: &PlenoxelsConfig,
) -> Vec<f32> {
    let (bricks, n_values) = (old.bricks(), new.n_values());
    let ratio = f64::from(old.resolution) / f64::from(new.resolution);
    let mut to = vec![0.0; new.layout().len()];
    let rows = to.chunks_exact_mut(n_values * voxel_grid::BRICK);
    for (brick, place) in rows.zip(new.bricks().places()) {
        let Some(place) = place else { continue };
        for (corner, row) in brick.chunks_exact_mut(n_values).enumerate() {
            let within = [corner % 4, corner / 4 % 4, corner / 16];
            let at = [0, 1, 2].map(|a| (4 * place[a] as usize + within[a]) as f64 * ratio);
            let low = at.map(|p| p as u32);
            for c in 0..8u32 {
                let high = [0, 1, 2].map(|a| c >> a & 1);
                let weight: f64 = (0..3)
                    .map(|a| {
                        let fraction = at[a] - f64::from(low[a]);
                        if high[a] == 1 { fraction } else { 1.0 - fraction }
                    })
                    .product();
                let corner = [0, 1, 2].map(|a| low[a] + high[a]);
                if weight > 0.0
                    && let Some(number) = bricks.row_of(corner)
                {
                    let values = &from[number * n_values..][..n_values];
                    row.iter_mut().zip(values).for_each(|(to, v)| *to += weight as f32 * v);
                }
            }
        }
    }
    to
}

/// Checks a field that was put together.
pub(super) fn validated(field: PlenoxelField<'_>) -> Result<AnyField<'_>, Error> {
    let field = AnyField::Plenoxels(field);
    field.validate()?;
    Ok(field)
}
