//! From an encoded point to density and colour: the part that the field kinds
//! share.

use fearless_simd::{Simd, SimdBase};

use crate::Error;
use crate::encoding::spherical_harmonics;
use crate::field::{MAX_CHANNELS, MAX_SIGMA, Samples};
use crate::lanes;
use crate::network::{Dense, Mlp};
use crate::scratch::{Limits, Workspace};
use crate::tensor::DType;

/// When view-dependent colour is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// For every sample; the ray accumulates three colours.
    PerSample,
    /// Once a ray ("deferred"): the ray accumulates features, and the colour
    /// network reads their average. Much cheaper.
    PerRay,
}

/// Density network and colour network.
///
/// `density` reads the encoded point and returns `1 + n_features` values: value 0
/// is the logarithm of the density, the rest are features.
/// `color` reads `[features, harmonics(direction)]` and returns three values;
/// their logistic is the colour.
#[derive(Clone, Copy, Debug)]
pub struct Decoder<'a> {
    /// Encoded point to log density and features.
    pub density: Mlp<'a>,
    /// Features and direction to colour.
    pub color: Mlp<'a>,
    /// Features that the colour network reads.
    pub n_features: u32,
    /// Degree of the spherical harmonics of the direction, 1 to 4; 1 is
    /// independent of the view.
    pub sh_degree: u32,
    /// When colour is computed.
    pub shading: Shading,
    /// Added to the log density: `sigma = exp(min(raw + log_density_bias, 15))`,
    /// in 1 / scene unit. It carries the unit of length.
    pub log_density_bias: f32,
}

impl Decoder<'_> {
    /// Checks that networks, features and encoding fit together; `n_encoded` is
    /// the size of an encoded position.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn validate(&self, n_encoded: usize) -> Result<(), Error> {
        let n_features = self.n_features as usize;
        if n_features == 0 || n_features > MAX_CHANNELS {
            return Err(Error::Range("number of features"));
        }
        if !(1..=spherical_harmonics::MAX_DEGREE).contains(&self.sh_degree) {
            return Err(Error::Range("degree of the spherical harmonics"));
        }
        if self.log_density_bias.is_nan() || self.log_density_bias.abs() >= 64.0 {
            return Err(Error::Range("log density bias"));
        }
        if self.density.n_input() != n_encoded {
            return Err(Error::Shape("position encoding and density network"));
        }
        if self.density.n_output() != 1 + n_features {
            return Err(Error::Shape("density network and number of features"));
        }
        if self.color.n_input() != n_features + spherical_harmonics::n_output(self.sh_degree) {
            return Err(Error::Shape("colour network and its inputs"));
        }
        if self.color.n_output() != 3 {
            return Err(Error::Shape("colour network: three outputs"));
        }
        if self.color.layers()[0].weight.dtype() != self.density.layers()[0].weight.dtype() {
            return Err(Error::Shape("networks of different types"));
        }
        Ok(())
    }

    /// How the networks' parameters are stored.
    #[must_use]
    pub fn dtype(&self) -> DType {
        self.density.layers()[0].weight.dtype()
    }

    /// Scratch that a field needs whose points are encoded to `n_encoded` values.
    #[must_use]
    pub fn limits(&self, n_encoded: usize) -> Limits {
        Limits {
            width: n_encoded.max(self.density.max_width()).max(self.color.max_width()),
            rows: self.rows(n_encoded),
            channels: self.channels().max(self.n_features as usize).max(3),
            ray_samples: 0,
        }
    }

    /// Rows of samples in each of the two buffers that layers alternate between.
    fn rows(&self, n_encoded: usize) -> [usize; 2] {
        let mut rows = [n_encoded, 0];
        let colors = (self.shading == Shading::PerSample).then_some(&self.color);
        for network in [&self.density].into_iter().chain(colors) {
            rows[0] = rows[0].max(network.n_input());
            let (_, hidden) = network.layers().split_last().unwrap_or((&Dense::EMPTY, &[]));
            for (i, layer) in hidden.iter().enumerate() {
                let rows = &mut rows[(i + 1) % 2];
                *rows = layer.weight.cols().max(*rows);
            }
        }
        rows
    }

    /// Values that a ray accumulates: K.
    #[must_use]
    pub const fn channels(&self) -> usize {
        match self.shading {
            Shading::PerSample => 3,
            Shading::PerRay => self.n_features as usize,
        }
    }

    /// From encoded points in `work.a` to sigma and features in `work.output`: without the
    /// colours of per-sample shading, [`density_features`](Self::density_features).
    #[inline(always)]
    pub fn densities<S: Simd>(&self, simd: S, n: usize, work: &mut Workspace<'_>) {
        let Workspace { a, b, output, panel, stride, rounded } = work;
        self.density.forward(simd, a, b, output, n, *stride, panel, *rounded);
        simd.vectorize(
            #[inline(always)]
            || {
                for sigma in output[..n].chunks_exact_mut(S::f32s::LEN) {
                    let log = S::f32s::from_slice(simd, sigma) + self.log_density_bias;
                    // Cut off after `exp`, which takes NaN to 0: what `min` does with
                    // NaN differs from machine to machine.
                    lanes::exp(simd, log).min(S::f32s::splat(simd, MAX_SIGMA)).store_slice(sigma);
                }
            },
        );
    }

    /// From encoded points in `work.a` to sigma and channels in `work.output`,
    /// see [`FieldKernels::decode`](crate::field::FieldKernels::decode).
    pub fn density_features<S: Simd>(
        &self,
        simd: S,
        samples: Samples<'_>,
        work: &mut Workspace<'_>,
    ) {
        let (n, stride) = (samples.len(), work.stride);
        self.densities(simd, n, work);
        if self.shading == Shading::PerSample {
            let features = &work.output[stride..(1 + self.n_features as usize) * stride];
            work.a[..features.len()].copy_from_slice(features);
            self.colors(simd, samples.directions, n, work);
        }
    }

    /// From features in the first `n_features` rows of `work.a` and unit
    /// directions to colours in rows 1 to 3 of `work.output`, in [0, 1].
    /// `n` is a multiple of 16.
    pub fn colors<S: Simd>(
        &self,
        simd: S,
        directions: [&[f32]; 3],
        n: usize,
        work: &mut Workspace<'_>,
    ) {
        let (stride, rounded) = (work.stride, work.rounded);
        let Workspace { a, b, output, panel, .. } = work;
        let rows = &mut a[self.n_features as usize * stride..];
        self.harmonics(simd, directions, n, rows, stride);
        let rgb = &mut output[stride..];
        self.color.forward(simd, a, b, rgb, n, stride, panel, rounded);
        simd.vectorize(
            #[inline(always)]
            || {
                for row in rgb.chunks_mut(stride).take(3) {
                    for values in row[..n].chunks_exact_mut(S::f32s::LEN) {
                        let value = S::f32s::from_slice(simd, values);
                        lanes::logistic(simd, value).store_slice(values);
                    }
                }
            },
        );
    }

    /// Writes the harmonics of `n` unit directions, a multiple of 16: value i of
    /// direction s goes to `out[i * stride + s]`.
    pub fn harmonics<S: Simd>(
        &self,
        simd: S,
        directions: [&[f32]; 3],
        n: usize,
        out: &mut [f32],
        stride: usize,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let one = S::f32s::splat(simd, 1.0);
                let mut values = [one; spherical_harmonics::n_output(4)];
                let n_output = spherical_harmonics::n_output(self.sh_degree);
                for first in (0..n).step_by(S::f32s::LEN) {
                    let at = |axis: usize| {
                        S::f32s::from_slice(simd, &directions[axis][first..][..S::f32s::LEN])
                    };
                    let d = [at(0), at(1), at(2)];
                    spherical_harmonics::evaluate_each(self.sh_degree, d, one, &mut values);
                    for (row, value) in values.iter().enumerate().take(n_output) {
                        value.store_slice(&mut out[row * stride + first..][..S::f32s::LEN]);
                    }
                }
            },
        );
    }
}
