//! Small models for the reference's tests.

extern crate std;
use std::vec;
use std::vec::Vec;

use crate::field::{AnyField, Decoder, Shading};
use crate::network::{Dense, Mlp};
use crate::{ColorSpace, DType, Display, Layout, Model, Ray, Sampling, Space, TensorView};

/// An f32 tensor of the given values; its bytes are never freed.
pub(crate) fn tensor(rows: usize, cols: usize, values: &[f32]) -> TensorView<'static> {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    TensorView::new(bytes.leak(), DType::F32, [rows as u32, cols as u32], 0, Layout::RowMajor)
        .unwrap()
}

/// A dense layer; `weight` is input-major.
pub(crate) fn dense(n_in: usize, n_out: usize, weight: &[f32], bias: &[f32]) -> Dense<'static> {
    Dense { weight: tensor(n_in, n_out, weight), bias: Some(tensor(1, n_out, bias)) }
}

/// A position encoding one of whose values is `2 u.z - 1`.
pub(crate) struct Kind {
    /// Values that the encoding gives.
    n_encoded: usize,
    /// Which of them is `2 u.z - 1`.
    z: usize,
    field: fn(Decoder<'static>) -> AnyField<'static>,
}

/// One encoding for each field kind that this build links.
pub(crate) fn kinds() -> Vec<Kind> {
    vec![
        #[cfg(feature = "hash-grid")]
        Kind {
            n_encoded: 1,
            z: 0,
            field: |decoder| {
                // One dense level, u at grid position u + 0.5. Corner z holds 2 z - 2, and
                // between corners the value is linear: 2 (u.z + 0.5) - 2.
                let config = crate::encoding::HashGridConfig {
                    n_levels: 1,
                    n_features_per_level: 1,
                    log2_hashmap_size: 6,
                    base_resolution: 2,
                    per_level_scale: 2.0,
                    index: crate::encoding::GridIndex::Blocked,
                };
                // Entry 8 (x + 2 y + 4 z) + ...: blocks of two corners, two along an axis.
                let corner_z = |entry: usize| 2 * (entry / 32) + (entry % 8) / 4;
                let values: Vec<f32> = (0..64).map(|e| 2.0 * corner_z(e) as f32 - 2.0).collect();
                let mut levels = [TensorView::EMPTY; crate::encoding::MAX_LEVELS];
                levels[0] = tensor(64, 1, &values);
                let grid = crate::encoding::HashGrid { config, levels };
                AnyField::HashGrid(crate::field::HashGridField { grid, decoder })
            },
        },
        #[cfg(feature = "planes")]
        Kind {
            n_encoded: 48,
            z: 32,
            field: |decoder| {
                use crate::encoding::{Planes, planes};
                // Two entries along an axis. The first component along z is 1 all over its
                // plane, and -1 and 1 at the ends of its line; the others are 0.
                let mut pairs = [planes::Pair::EMPTY; planes::MAX_PAIRS];
                for (number, pair) in pairs.iter_mut().enumerate().take(6) {
                    let (mut plane, mut line) = ([0.0; 32], [0.0; 16]);
                    if number == 4 {
                        plane.iter_mut().step_by(8).for_each(|value| *value = 1.0);
                        (line[0], line[8]) = (-1.0, 1.0);
                    }
                    *pair = planes::Pair { plane: tensor(4, 8, &plane), line: tensor(2, 8, &line) };
                }
                let planes = Planes { resolution: 2, n_components: 16, pairs };
                AnyField::Planes(crate::field::PlanesField { planes, decoder })
            },
        },
    ]
}

/// A model of two features in the box [-1, 1]³, sampled every 0.25 from 1 to 6
/// along a ray: change what a test is about, then build.
pub(crate) struct SceneBuilder {
    field: fn(Decoder<'static>) -> AnyField<'static>,
    /// The networks: one layer each, colour 0.5 everywhere, shaded per sample,
    /// no view dependence.
    pub decoder: Decoder<'static>,
    /// Where samples lie.
    pub sampling: Sampling,
}

impl SceneBuilder {
    /// Log density and the two features are `slope * (2 u.z - 1) + bias`. In the
    /// box, `2 u.z - 1` is the scene's z.
    pub(crate) fn new(kind: &Kind, slope: [f32; 3], bias: [f32; 3]) -> Self {
        let mut weight = vec![0.0; kind.n_encoded * 3];
        weight[3 * kind.z..][..3].copy_from_slice(&slope);
        let density = Mlp::new(&[dense(kind.n_encoded, 3, &weight, &bias)]).unwrap();
        let color = Mlp::new(&[dense(3, 3, &[0.0; 9], &[0.0; 3])]).unwrap();
        Self {
            field: kind.field,
            decoder: Decoder {
                density,
                color,
                n_features: 2,
                sh_degree: 1,
                shading: Shading::PerSample,
                log_density_bias: 0.0,
            },
            sampling: Sampling { step: 0.25, near: 1.0, far: 6.0, min_transmittance: 0.0 },
        }
    }

    /// The density network's only layer.
    pub(crate) fn density_layer(&self) -> Dense<'static> {
        self.decoder.density.layers()[0]
    }

    /// Replaces the colour network.
    pub(crate) fn set_color(&mut self, layers: &[Dense<'static>]) {
        self.decoder.color = Mlp::new(layers).unwrap();
    }

    /// The model, without occupancy.
    pub(crate) fn build(&self) -> Model<'static> {
        Model {
            field: (self.field)(self.decoder),
            space: Space::Box { min: [-1.0; 3], max: [1.0; 3] },
            occupancy: None,
            sampling: self.sampling,
            hierarchical: None,
            display: Display {
                background: [1.0; 3],
                color_space: ColorSpace::Srgb,
                tolerance: Display::TOLERANCE,
            },
        }
    }
}

/// Along +z, inside the box for t = 2 to 4.
pub(crate) const ALONG_Z: Ray = Ray { origin: [0.1, -0.2, -3.0], direction: [0.0, 0.0, 1.0] };
