//! A multiresolution hash grid (Müller et al. 2022), trainable: what it adds to
//! `encoded` fields.

mod positions;
mod scatter;

use fearless_simd::Simd;
use pocketnerf_core::encoding::hash_grid::{self, HashGrid, HashGridConfig};
use pocketnerf_core::encoding::{GridIndex, MAX_LEVELS};
use pocketnerf_core::field::{Decoder, HashGridField, Shading};
use pocketnerf_core::{AnyField, Error, TensorView};

use super::encoded::{EncodedFieldConfig, Encoding};
use super::{FieldConfig, Range};

/// A hash grid, a density network and a colour network.
pub type HashGridFieldConfig = EncodedFieldConfig<HashGridConfig>;

impl Default for HashGridFieldConfig {
    fn default() -> Self {
        Self {
            grid: HashGridConfig {
                n_levels: 9,
                n_features_per_level: 4,
                log2_hashmap_size: 17,
                base_resolution: 16,
                per_level_scale: 1.65,
                index: GridIndex::Blocked,
            },
            density_hidden: vec![64],
            color_hidden: vec![64, 64],
            n_features: 15,
            sh_degree: 4,
            shading: Shading::PerRay,
        }
    }
}

impl HashGridFieldConfig {
    /// The shape of a field.
    pub(in crate::field) fn of(field: &HashGridField<'_>) -> Self {
        Self::with(field.grid.config, &field.decoder)
    }
}

/// Half width of the uniform distribution of a grid's entries (Müller et al. 2022, section 4).
const INITIAL_RANGE: f32 = 1e-4;

impl Encoding for HashGridConfig {
    type View<'a> = HashGrid<'a>;

    const TABLES_OF_A_TASK: usize = 1;

    fn n_output(&self) -> usize {
        self.n_output()
    }

    fn tables(&self) -> Vec<[usize; 2]> {
        let rows = (0..self.n_levels as usize).map(|level| self.level(level).entries as usize);
        rows.map(|rows| [rows, self.n_features_per_level as usize]).collect()
    }

    fn initial_range(&self, _: usize) -> [f32; 2] {
        [-INITIAL_RANGE, INITIAL_RANGE]
    }

    fn view<'a>(
        &self,
        tables: &[Range],
        table: impl Fn(&Range) -> Result<TensorView<'a>, Error>,
    ) -> Result<HashGrid<'a>, Error> {
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        for (level, range) in levels.iter_mut().zip(tables) {
            *level = table(range)?;
        }
        Ok(HashGrid { config: *self, levels })
    }

    fn field<'a>(grid: HashGrid<'a>, decoder: Decoder<'a>) -> AnyField<'a> {
        AnyField::HashGrid(HashGridField { grid, decoder })
    }

    fn config(field: HashGridFieldConfig) -> FieldConfig {
        FieldConfig::HashGrid(field)
    }

    fn encode<S: Simd>(
        simd: S,
        grid: &HashGrid<'_>,
        points: [&[f32]; 3],
        out: &mut [f32],
        stride: usize,
    ) {
        hash_grid::encode(simd, grid, points, out, stride);
    }

    fn scatter<S: Simd>(
        &self,
        simd: S,
        (number, _): (usize, &[TensorView<'_>]),
        points: [&[f32]; 3],
        (rows, stride): (&[f32], usize),
        gradient: &mut [f32],
    ) {
        let features = self.n_features_per_level as usize;
        let rows = &rows[number * features * stride..];
        let level = self.level(number);
        scatter::scatter_level(simd, &level, features, points, rows, stride, gradient);
    }

    fn n_levels(&self) -> usize {
        self.n_levels as usize
    }

    fn points_back<S: Simd>(
        &self,
        simd: S,
        tables: &[&[f32]],
        points: [&[f32]; 3],
        (rows, stride): (&[f32], usize),
        levels: &[f32],
        d_points: &mut [&mut [f32]; 3],
    ) {
        let shape = (self.n_features_per_level as usize, stride);
        let shares = levels.iter().take(self.n_levels as usize).enumerate();
        for (l, share) in shares.filter(|(_, share)| **share > 0.0) {
            let (level, rows) = (self.level(l), &rows[l * shape.0 * stride..]);
            let table = (tables[l], rows, shape);
            positions::add_level(simd, (&level, *share), table, points, d_points);
        }
    }

    fn validate(&self) -> Result<(), Error> {
        self.validate()
    }
}
