//! The loss in f64, one sample and one weight at a time.

use std::ops::{Add, Mul, Sub};

use pocketnerf_core::encoding::spherical_harmonics::{evaluate_each, n_output};
use pocketnerf_core::field::Shading;

use super::exact::Exact;
use super::{COLOR, DENSITY, DepthTerm, EncodedFieldConfig, MIN_TRANSMITTANCE};
use crate::field::{Layout, Part, Role};
use crate::trainer::TrainingRay;
use crate::trainer::step::group::Record;

/// The loss of some rays as a function of the parameters.
pub(super) struct Loss<E: Exact> {
    config: EncodedFieldConfig<E>,
    layout: Layout,
    /// Distance between samples.
    step: f64,
    /// Added to the logarithm of the density.
    bias: f64,
    rays: Vec<Seen<E>>,
    /// Whether depths count, see [`DepthTerm`].
    with_depth: bool,
}

/// A ray with all that no parameter changes.
struct Seen<E: Exact> {
    ray: TrainingRay,
    direction: [f64; 3],
    harmonics: Vec<f64>,
    /// Unit coordinates.
    points: Vec<[f64; 3]>,
    /// Each with the steps that it stands for, and its distance.
    samples: Vec<(E::Places, [f64; 2])>,
}

impl<E: Exact> Loss<E> {
    pub(super) fn new(
        config: EncodedFieldConfig<E>,
        layout: Layout,
        (step, bias): (f32, f32),
        with_depth: bool,
        rays: impl Iterator<Item = (TrainingRay, Vec<(Record, f32)>)>,
    ) -> Self {
        let seen = |(ray, samples): (TrainingRay, Vec<(Record, f32)>)| {
            let points: Vec<_> = samples.iter().map(|(s, _)| s.point.map(f64::from)).collect();
            let lengths = samples.iter().map(|(s, t)| [s.steps, *t].map(f64::from));
            let direction = ray.ray.direction.map(f64::from);
            Seen {
                ray,
                direction,
                harmonics: harmonics(config.sh_degree, direction),
                samples: points.iter().map(|p| config.grid.places(*p)).zip(lengths).collect(),
                points,
            }
        };
        let rays = rays.map(seen).collect();
        Self { config, layout, step: f64::from(step), bias: f64::from(bias), rays, with_depth }
    }

    /// The loss where the points and the direction of each ray are moved.
    pub(super) fn moved(
        &self,
        point: impl Fn(usize, [f64; 3]) -> [f64; 3],
        direction: impl Fn(usize, [f64; 3]) -> [f64; 3],
    ) -> Self {
        let rays = self.rays.iter().enumerate().map(|(r, seen)| {
            let points: Vec<_> = seen.points.iter().map(|p| point(r, *p)).collect();
            let encodings = points.iter().map(|p| self.config.grid.places(*p));
            let direction = direction(r, seen.direction);
            Seen {
                ray: seen.ray,
                direction,
                harmonics: harmonics(self.config.sh_degree, direction),
                samples: encodings.zip(seen.samples.iter().map(|(_, lengths)| *lengths)).collect(),
                points,
            }
        });
        Self {
            config: self.config.clone(),
            layout: self.layout.clone(),
            rays: rays.collect(),
            ..*self
        }
    }

    /// Half the sum of squared errors of colours and, where they count, depths.
    pub(super) fn at(&self, parameters: &[f64]) -> f64 {
        0.5 * self.rays.iter().map(|seen| self.squared_error(parameters, seen)).sum::<f64>()
    }

    fn squared_error(&self, parameters: &[f64], seen: &Seen<E>) -> f64 {
        let per_sample = self.config.shading == Shading::PerSample;
        let (mut transmittance, mut opacity, mut depth) = (1.0, 0.0, 0.0);
        let mut sums = vec![0.0; if per_sample { 3 } else { self.config.n_features }];
        for (places, [steps, t]) in &seen.samples {
            let mut values = self.config.grid.encoded(&self.layout, parameters, places);
            self.network(parameters, false, &mut values);
            let log_density = values.remove(0) + self.bias;
            if per_sample {
                values = self.color(parameters, values, seen);
            }
            let alpha = 1.0 - (-log_density.min(15.0).exp() * self.step * steps).exp();
            let weight = transmittance * alpha;
            transmittance -= weight;
            opacity += weight;
            depth += weight * t;
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += weight * value;
            }
            if transmittance < f64::from(MIN_TRANSMITTANCE) {
                break;
            }
        }
        if opacity > 0.0 {
            // A ray that has ended counts as opaque.
            let ended = transmittance < f64::from(MIN_TRANSMITTANCE);
            let total = opacity;
            opacity = if ended { 1.0 } else { total };
            let mut mean = sums.iter().map(|sum| sum / total).collect();
            if !per_sample {
                mean = self.color(parameters, mean, seen);
            }
            sums = mean.iter().map(|c| opacity * c).collect();
        }
        let TrainingRay { background, background_variance, target, alpha, weight, .. } = seen.ray;
        let error = |c| {
            let color = sums.get(c).copied().filter(|_| opacity > 0.0).unwrap_or(0.0);
            color + (1.0 - opacity) * f64::from(background[c]) - f64::from(target[c])
        };
        // Expected over the backgrounds: the mean's, and the variance's.
        let through = opacity - f64::from(alpha);
        let spread = 3.0 * f64::from(background_variance) * through * through;
        let color = (0..3).map(|c| error(c) * error(c)).sum::<f64>() + spread;
        let off = if self.with_depth { depth - f64::from(DepthTerm::TARGET) } else { 0.0 };
        f64::from(weight) * (color + off * off)
    }

    fn color(&self, parameters: &[f64], mut features: Vec<f64>, seen: &Seen<E>) -> Vec<f64> {
        features.extend(&seen.harmonics);
        self.network(parameters, true, &mut features);
        features.iter().map(|x| 1.0 / (1.0 + (-x).exp())).collect()
    }

    fn network(&self, parameters: &[f64], color: bool, values: &mut Vec<f64>) {
        let config = &self.config;
        let n_hidden = if color { &config.color_hidden } else { &config.density_hidden }.len();
        for i in 0..=n_hidden {
            let network = if color { COLOR } else { DENSITY };
            let parts = [Role::Weight, Role::Bias].map(|role| Part { network, layer: i, role });
            let [weight, bias] = parts.map(|part| &parameters[self.layout.range(part).indices()]);
            let output = |o: usize| {
                let column = weight.iter().skip(o).step_by(bias.len());
                let sum = bias[o] + column.zip(&*values).map(|(w, x)| w * x).sum::<f64>();
                if i < n_hidden { sum.max(0.0) } else { sum }
            };
            *values = (0..bias.len()).map(output).collect();
        }
    }
}

/// A number that core's harmonics are computed in.
#[derive(Clone, Copy)]
struct Wide(f64);

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl Mul<f32> for Wide {
    type Output = Self;

    fn mul(self, factor: f32) -> Self {
        Self(self.0 * f64::from(factor))
    }
}

fn harmonics(degree: u32, direction: [f64; 3]) -> Vec<f64> {
    let mut out = [Wide(0.0); 16];
    evaluate_each(degree, direction.map(Wide), Wide(1.0), &mut out);
    out[..n_output(degree)].iter().map(|value| value.0).collect()
}
