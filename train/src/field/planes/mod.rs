//! Planes and lines (Chen et al. 2022, "TensoRF"), trainable: what they add to
//! `encoded` fields.

mod config;
mod growth;
mod positions;
mod scatter;
mod smoothing;

use fearless_simd::Simd;
use pocketnerf_core::encoding::Planes;
use pocketnerf_core::encoding::planes::{self, FEATURES, MAX_PAIRS, Pair};
use pocketnerf_core::field::{Decoder, PlanesField, Shading};
use pocketnerf_core::store::{F32, I8};
use pocketnerf_core::{AnyField, DType, Error, TensorView};

pub use config::PlanesConfig;

use super::encoded::{EncodedFieldConfig, Encoding};
use super::{FieldConfig, Range, Training};

/// Planes and lines, a density network and a colour network.
pub type PlanesFieldConfig = EncodedFieldConfig<PlanesConfig>;

impl Default for PlanesFieldConfig {
    fn default() -> Self {
        Self {
            grid: PlanesConfig::new(300, 16),
            density_hidden: vec![64],
            color_hidden: vec![64, 64],
            n_features: 15,
            sh_degree: 4,
            shading: Shading::PerRay,
        }
    }
}

/// What lines and planes lie between at first. Products are small, and both have a gradient.
const INITIAL_LINES: [f32; 2] = [0.8, 1.2];
const INITIAL_PLANES: [f32; 2] = [-0.05, 0.05];
/// What photographs leave open is smooth, and takes few bytes: docs/lab/planes.md.
const SMOOTHING: f32 = 1000.0;
/// A run of 750 steps loses 1.5 dB beside one of 3,000, one of 1,500 steps 0.4 (docs/stability.md).
const LEAST_STEPS: u32 = 1024;

impl Encoding for PlanesConfig {
    type View<'a> = Planes<'a>;

    const TABLES_OF_A_TASK: usize = 2;

    fn training(&self) -> Training {
        Training {
            grid_decay: 0.0,
            grid_smoothing: SMOOTHING,
            least_steps: LEAST_STEPS,
            ..Training::USUAL
        }
    }

    fn n_output(&self) -> usize {
        3 * self.n_components as usize
    }

    fn tables(&self) -> Vec<[usize; 2]> {
        [self.pair()].repeat(Planes::n_pairs(self.n_components)).concat()
    }

    fn initial_range(&self, table: usize) -> [f32; 2] {
        if table.is_multiple_of(2) { INITIAL_PLANES } else { INITIAL_LINES }
    }

    fn view<'a>(
        &self,
        tables: &[Range],
        table: impl Fn(&Range) -> Result<TensorView<'a>, Error>,
    ) -> Result<Planes<'a>, Error> {
        let mut pairs = [Pair::EMPTY; MAX_PAIRS];
        for (pair, ranges) in pairs.iter_mut().zip(tables.as_chunks::<2>().0) {
            *pair = Pair { plane: table(&ranges[0])?, line: table(&ranges[1])? };
        }
        Ok(Planes { resolution: self.resolution, n_components: self.n_components, pairs })
    }

    fn field<'a>(planes: Planes<'a>, decoder: Decoder<'a>) -> AnyField<'a> {
        AnyField::Planes(PlanesField { planes, decoder })
    }

    fn config(field: PlanesFieldConfig) -> FieldConfig {
        FieldConfig::Planes(field)
    }

    fn encode<S: Simd>(
        simd: S,
        planes: &Planes<'_>,
        points: [&[f32]; 3],
        out: &mut [f32],
        stride: usize,
    ) {
        planes::encode(simd, planes, points, out, stride);
    }

    fn scatter<S: Simd>(
        &self,
        simd: S,
        (number, tables): (usize, &[TensorView<'_>]),
        points: [&[f32]; 3],
        (rows, stride): (&[f32], usize),
        gradient: &mut [f32],
    ) {
        let pair = Pair { plane: tables[0], line: tables[1] };
        let shape = (pair, Planes::axis(self.n_components, number), self.resolution);
        let rows = (&rows[number * FEATURES * stride..], stride);
        match tables[0].dtype() {
            DType::F32 => scatter::scatter_pair::<S, F32>(simd, shape, points, rows, gradient),
            _ => scatter::scatter_pair::<S, I8>(simd, shape, points, rows, gradient),
        }
    }

    fn n_levels(&self) -> usize {
        positions::LEVELS
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
        simd.vectorize(
            #[inline(always)]
            || {
                for (number, pair) in tables.as_chunks::<2>().0.iter().enumerate() {
                    let axis = Planes::axis(self.n_components, number);
                    let shape = (pair[0], pair[1], axis, self.resolution);
                    let rows = (&rows[number * FEATURES * stride..], stride);
                    for reach in positions::reaches(self.resolution, levels) {
                        positions::add_pair(shape, points, rows, reach, d_points);
                    }
                }
            },
        );
    }

    fn smooth<S: Simd>(
        &self,
        simd: S,
        table: usize,
        share: f32,
        (parameters, gradient): (&mut [f32], &[f32]),
    ) {
        let side = self.resolution as usize;
        match table.is_multiple_of(2) {
            true => smoothing::plane(simd, side, share, parameters, gradient),
            false => smoothing::line(share, parameters, gradient),
        }
    }

    fn validate(&self) -> Result<(), Error> {
        self.check()
    }

    fn due(&self, progress: f32) -> Option<Self> {
        self.finer(progress)
    }

    fn carried_over(&self, finer: &Self, tables: &[&[f32]]) -> Vec<f32> {
        let [from, to] = [self, finer].map(|planes| planes.resolution as usize);
        let pairs = tables.as_chunks::<2>().0.iter();
        pairs
            .flat_map(|[plane, line]| {
                [growth::plane(plane, from, to), growth::line(line, from, to)].concat()
            })
            .collect()
    }

    fn section(&self) -> Option<Vec<u8>> {
        Some(self.section())
    }
}
