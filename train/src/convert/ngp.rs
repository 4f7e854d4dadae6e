//! Hash grids of other programs, as a model.

use pocketnerf_core::{
    AnyField, Camera, ColorSpace, Display, Model, Occupancy, Sampling, SimdLevel, Space,
};
use pocketnerf_formats::Scene;
use pocketnerf_formats::import::ngp::{Cells, Ngp};

use super::bake::Baker;
use super::{ConvertError, Settings};
use crate::trainer::pack;

/// Most cells along an axis.
const MOST_CELLS: u32 = 512;
/// Fewest cells along an axis.
const LEAST_CELLS: u32 = 8;
/// Most blocks of cells that are not empty.
const MOST_BLOCKS: usize = u16::MAX as usize;
/// How far rays reach, sides of the box: farther cameras see little.
const REACH: f32 = 16.0;
/// Most steps that a ray may have before its end.
const MOST_STEPS: f32 = (1 << 19) as f32;

/// A hash grid and the cells that it fills.
#[derive(Debug)]
pub struct NgpConversion {
    ngp: Ngp,
    near: f32,
    background: [f32; 3],
    occupied: Occupied,
}

/// Cells as core reads them.
#[derive(Debug)]
struct Occupied {
    resolution: u32,
    coarse: Vec<u8>,
    fine: Vec<u8>,
}

impl NgpConversion {
    /// Takes over the program's cells, or finds the occupied ones if it has none. `crop` is the
    /// part to show, in the dataset's coordinates.
    ///
    /// # Errors
    /// [`ConvertError::Missing`] if the colour behind the scene is unknown,
    /// [`ConvertError::Empty`] if no cell is occupied.
    pub fn new(
        ngp: Ngp,
        settings: Settings,
        crop: Option<[[f32; 3]; 2]>,
        simd: SimdLevel,
    ) -> Result<Self, ConvertError> {
        let level = simd.token()?;
        let around = ngp.context();
        let near = settings.near.unwrap_or(around.near);
        if !(0.0..1e6).contains(&near) {
            return Err(ConvertError::Bounds { near, far: f32::INFINITY });
        }
        let background = settings
            .background
            .or(around.background)
            .ok_or_else(|| ConvertError::Missing("--background".to_owned()))?;
        let [min, max] = around.bounds;
        let space = Space::Box { min, max };
        space.validate()?;
        let crops = [crop.map(|corners| to_model(&around.scene, corners)), around.crop];
        let inside =
            |unit: [[f32; 3]; 2]| crops.iter().flatten().all(|crop| touches(&space, unit, crop));
        let occupied = match &around.cells {
            Some(cells) => Occupied::of(cells, inside),
            None => {
                let field = AnyField::HashGrid(ngp.field()?);
                let baker = Baker { field: &field, level, seed: 0, step: around.step };
                let cells = baker.cells(&space);
                Occupied::within(cells.grown(), inside)
            }
        };
        if occupied.fine.is_empty() {
            return Err(ConvertError::Empty(around.bounds));
        }
        Ok(Self { near, background, occupied, ngp })
    }

    /// The model.
    ///
    /// # Errors
    /// What core refuses.
    pub fn model(&self) -> Result<Model<'_>, ConvertError> {
        let around = self.ngp.context();
        let [min, max] = around.bounds;
        let Occupied { resolution, coarse, fine } = &self.occupied;
        let reach = (REACH * (max[0] - min[0])).min(MOST_STEPS * around.step);
        let model = Model {
            field: AnyField::HashGrid(self.ngp.field()?),
            space: Space::Box { min, max },
            occupancy: Some(Occupancy::new(*resolution, 1, coarse, fine)?),
            sampling: Sampling {
                step: around.step,
                near: self.near,
                far: self.near + reach,
                min_transmittance: around.min_transmittance,
            },
            hierarchical: None,
            display: Display {
                background: self.background,
                color_space: ColorSpace::Srgb,
                tolerance: Display::TOLERANCE,
            },
        };
        model.validate()?;
        Ok(model)
    }

    /// The program that wrote the checkpoint.
    #[must_use]
    pub const fn program(&self) -> &'static str {
        self.ngp.program()
    }

    /// From the model's coordinates to those of the dataset.
    #[must_use]
    pub const fn scene(&self) -> Scene<'static> {
        self.ngp.context().scene
    }

    /// The cameras of its training views.
    #[must_use]
    pub fn views(&self) -> &[Camera] {
        &self.ngp.context().views
    }
}

impl Occupied {
    /// Cells as small as the program's smallest, or as there is room for.
    fn of(cells: &Cells, inside: impl Fn([[f32; 3]; 2]) -> bool) -> Self {
        let mut resolution = cells.finest().next_multiple_of(LEAST_CELLS).min(MOST_CELLS);
        loop {
            let within =
                cells.on_grid(resolution).filter(|cell| inside(unit_box(resolution, *cell)));
            if let Ok((coarse, fine)) = pack(resolution, within)
                && fine.len() <= MOST_BLOCKS * pocketnerf_core::occupancy::BLOCK_BYTES
            {
                return Self { resolution, coarse, fine };
            }
            resolution = (resolution / 2).next_multiple_of(LEAST_CELLS);
        }
    }

    /// Those of some cells that are within the crop.
    fn within(cells: Occupancy<'_>, inside: impl Fn([[f32; 3]; 2]) -> bool) -> Self {
        let n = cells.resolution();
        let occupied = |cell: &u32| cells.cell(cell % n, cell / n % n, cell / (n * n));
        let all = (0..n * n * n).filter(occupied).filter(|cell| inside(unit_box(n, *cell)));
        let (coarse, fine) = pack(n, all).expect("a part of what had numbers");
        Self { resolution: n, coarse, fine }
    }
}

/// The corners of a cell, unit coordinates.
fn unit_box(n: u32, cell: u32) -> [[f32; 3]; 2] {
    let cell = [cell % n, cell / n % n, cell / (n * n)];
    [cell.map(|c| c as f32 / n as f32), cell.map(|c| (c + 1) as f32 / n as f32)]
}

/// Whether a cell is within a box in the space's coordinates, or partly so.
fn touches(space: &Space, cell: [[f32; 3]; 2], [min, max]: &[[f32; 3]; 2]) -> bool {
    let map = space.unit_map();
    let [low, high] = cell;
    let unit = |value: f32, a: usize| (value - map.min[a]) * map.scale;
    (0..3).all(|a| low[a] < unit(max[a], a) && unit(min[a], a) < high[a])
}

/// The box around what a box of the dataset is in the model's coordinates.
fn to_model(scene: &Scene<'_>, corners: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
    let corner = |c: usize| [0, 1, 2].map(|a| corners[c >> a & 1][a]);
    let all = [0, 1, 2, 3, 4, 5, 6, 7].map(|c| scene.to_model(corner(c)));
    let most = |pick: fn(f32, f32) -> f32| {
        all.into_iter().reduce(|a, b| [0, 1, 2].map(|i| pick(a[i], b[i])))
    };
    [most(f32::min), most(f32::max)].map(|corner| corner.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_of_the_dataset() {
        // The axes in turn, half as large, moved.
        let scene = Scene {
            scale: 2.0,
            rotation: [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            translation: [1.0, 2.0, 3.0],
            name: None,
        };
        let found = to_model(&scene, [[1.0, 2.0, 3.0], [3.0, 6.0, 9.0]]);
        assert_eq!(found, [[0.0, 0.0, 0.0], [2.0, 3.0, 1.0]]);
    }

    #[test]
    fn cells_in_a_box() {
        let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        let crop = [[-1.0, -1.0, -1.0], [0.0, 0.1, 1.0]];
        // Eight cells of unit side: x in the lower half, y into the upper one.
        let within: Vec<u32> =
            (0..8).filter(|cell| touches(&space, unit_box(2, *cell), &crop)).collect();
        assert_eq!(within, [0, 2, 4, 6]);
    }
}
