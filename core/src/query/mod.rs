//! Questions to a model beside pictures: what is where, whether a way is free, how far
//! things are.
//!
//! A [`Probe`] is a model, vector instructions and the caller's coordinates;
//! points, distances and densities are all in the caller's units. Questions take many
//! points at a time and the caller's scratch, allocate nothing, and may run on any
//! number of threads, each with scratch of its own. Sigma is 0 where occupancy says that
//! nothing is.
//!
//! | question | answer | |
//! |---|---|---|
//! | [`density`](Probe::density) | sigma | 1 / unit |
//! | [`radiance`](Probe::radiance) | colour and sigma | 1 / unit |
//! | [`density_gradient`](Probe::density_gradient), [`normal`] | slope of sigma, where surfaces face | 1 / unit² |
//! | [`occupied`](Probe::occupied), [`sphere_clear`](Probe::sphere_clear) | whether a point or a ball is free | |
//! | [`segment_transmittance`](Probe::segment_transmittance) | light that passes between two points | |
//! | [`collision_probability`](Probe::collision_probability) | whether a body hits anything | |
//! | [`depths`](Probe::depths) | how far a ray sees | unit |
//! | [`surface_normals`](Probe::surface_normals) | where what a ray sees faces | |
//!
//! Numbers that say nowhere are refused or count as occupied, never as free; no answer is
//! NaN, whatever a file holds. Normalised device coordinates have no density per length, so
//! that models in them have no probe.
//!
//! # Example
//! The fog of the crate's example, whose log density grows from -1 to 3 along x, two metres
//! of it; the caller counts in centimetres.
#![cfg_attr(all(feature = "std", feature = "hash-grid"), doc = "```")]
#![cfg_attr(not(all(feature = "std", feature = "hash-grid")), doc = "```ignore")]
//! # use pocketnerf_core::encoding::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
//! # use pocketnerf_core::field::{Decoder, HashGridField, Shading};
//! # use pocketnerf_core::network::{Dense, Mlp};
//! # use pocketnerf_core::{AnyField, ColorSpace, DType, Display, Layout, Model, Sampling, Space, TensorView};
//! # let config = HashGridConfig {
//! #     n_levels: 1,
//! #     n_features_per_level: 1,
//! #     log2_hashmap_size: 6,
//! #     base_resolution: 2,
//! #     per_level_scale: 1.0,
//! #     index: GridIndex::Blocked,
//! # };
//! # let corner_x = |entry: usize| entry / 8 % 2 * 2 + entry % 2;
//! # let grid: Vec<f32> = (0..64).map(|entry| 2.0 * corner_x(entry) as f32 - 2.0).collect();
//! # let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
//! # let (grid, density, bias) = (bytes(&grid), bytes(&[2.0, 0.0]), bytes(&[1.0, 0.0]));
//! # let color = bytes(&[0.0; 6]);
//! # let tensor = |bytes, shape| TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor);
//! # let mut levels = [TensorView::EMPTY; MAX_LEVELS];
//! # levels[0] = tensor(&grid, [64, 1])?;
//! # let model = Model {
//! #     field: AnyField::HashGrid(HashGridField {
//! #         grid: HashGrid { config, levels },
//! #         decoder: Decoder {
//! #             density: Mlp::new(&[Dense { weight: tensor(&density, [1, 2])?, bias: Some(tensor(&bias, [1, 2])?) }])?,
//! #             color: Mlp::new(&[Dense { weight: tensor(&color, [2, 3])?, bias: None }])?,
//! #             n_features: 1,
//! #             sh_degree: 1,
//! #             shading: Shading::PerRay,
//! #             log_density_bias: 0.0,
//! #         },
//! #     }),
//! #     space: Space::Box { min: [-1.0; 3], max: [1.0; 3] },
//! #     occupancy: None,
//! #     sampling: Sampling { step: 0.01, near: 0.0, far: 6.0, min_transmittance: 1e-3 },
//! #     hierarchical: None,
//! #     display: Display { background: [1.0; 3], color_space: ColorSpace::Srgb, tolerance: Display::TOLERANCE },
//! # };
//! use pocketnerf_core::query::{Depth, Similarity, normal};
//! use pocketnerf_core::{Probe, Ray, SimdLevel, Tuning};
//!
//! let centimetres = Similarity { scale: 100.0, ..Similarity::IDENTITY };
//! let probe = Probe::new(&model, SimdLevel::detect(), Tuning::SMALL)?.with_similarity(centimetres)?;
//! let mut scratch = vec![0.0; probe.scratch_len()];
//!
//! // e^(2 x + 1) a metre at x = 0.5 m; nothing outside the box.
//! let mut sigma = [0.0; 2];
//! probe.density(&[[50.0, 0.0, 0.0], [150.0, 0.0, 0.0]], &mut scratch, &mut sigma)?;
//! assert!((sigma[0] - 2f32.exp() / 100.0).abs() < 1e-5 && sigma[1] == 0.0);
//!
//! // It is thicker to the right, so that surfaces face left.
//! let mut gradient = [[0.0; 3]];
//! probe.density_gradient(&[[50.0, 0.0, 0.0]], &mut scratch, &mut gradient)?;
//! assert!(normal(gradient[0])[0] < -0.999);
//!
//! // From the left, half of the light is held back about where the integral of sigma is ln 2.
//! let ray = Ray { origin: [-200.0, 0.0, 0.0], direction: [1.0, 0.0, 0.0] };
//! let mut depth = [0.0];
//! probe.depths(&[ray], Depth::Median, None, &mut scratch, &mut depth)?;
//! let mut passes = [0.0];
//! let segment = [ray.origin, [depth[0] - 200.0, 0.0, 0.0]];
//! probe.segment_transmittance(&[segment], &mut scratch, &mut passes)?;
//! assert!((passes[0] - 0.5).abs() < 0.01);
//! # Ok::<(), pocketnerf_core::Error>(())
//! ```

mod clearance;
mod depth;
mod evaluate;
mod gradient;
mod march;
mod points;
mod similarity;
mod surface;
mod transmittance;

pub use depth::Depth;
pub use gradient::{gradient_spacing, normal};
pub use similarity::{Similarity, is_rotation};

use fearless_simd::Level;

use crate::scratch::{Limits, Scratch, Tuning, scratch_len};
use crate::space::UnitMap;
use crate::{Error, Model, SimdLevel};

/// A model to be queried, and the caller's coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Probe<'m> {
    model: &'m Model<'m>,
    map: UnitMap,
    similarity: Similarity,
    level: Level,
    limits: Limits,
    tuning: Tuning,
    /// Half of what differences are taken over, unit coordinates.
    spacing: f32,
}

impl<'m> Probe<'m> {
    /// A probe of `model` in its own coordinates. Parts of the model are checked here, once
    /// for all questions.
    ///
    /// # Errors
    /// Whatever [`Model::validate`] and [`Tuning::validate`] report;
    /// [`Error::SimdUnavailable`]; [`Error::Unsupported`] for a model whose space is no box.
    pub fn new(model: &'m Model<'m>, simd: SimdLevel, tuning: Tuning) -> Result<Self, Error> {
        model.validate()?;
        tuning.validate()?;
        if model.space.scene_box().is_none() {
            return Err(Error::Unsupported("its space is no box, and has no density per length"));
        }
        Ok(Self {
            model,
            map: model.space.unit_map(),
            similarity: Similarity::IDENTITY,
            level: simd.token()?,
            limits: model.field.limits(),
            tuning,
            spacing: gradient_spacing(&model.field),
        })
    }

    /// The same in the caller's coordinates, which this takes the model's to.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub fn with_similarity(self, similarity: Similarity) -> Result<Self, Error> {
        similarity.validate()?;
        Ok(Self { similarity, ..self })
    }

    /// The caller's coordinates.
    #[must_use]
    pub const fn similarity(&self) -> &Similarity {
        &self.similarity
    }

    /// `f32` values of scratch to hand to every question: as many as
    /// [`RenderOptions::scratch_len`](crate::RenderOptions::scratch_len), and the same
    /// memory will do. A constant for all models of a size is
    /// [`scratch_len`]`(limits, tuning)`.
    #[must_use]
    pub const fn scratch_len(&self) -> usize {
        scratch_len(self.limits, self.tuning)
    }

    /// The scratch, if it is long enough.
    fn cut<'s>(&self, scratch: &'s mut [f32]) -> Result<Scratch<'s>, Error> {
        let (needed, given) = (self.scratch_len(), scratch.len());
        if given < needed {
            return Err(Error::ScratchTooSmall { needed, given });
        }
        Ok(Scratch::cut(scratch, self.limits, self.tuning))
    }
}

#[cfg(test)]
mod tests;
