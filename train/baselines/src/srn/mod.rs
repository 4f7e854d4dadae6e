//! Scene representation networks (Sitzmann et al. 2019): a network gives features of a point, a
//! recurrent one marches along a ray by what they are, and a third makes a colour of the features
//! where it ends.

mod march;
#[cfg(test)]
pub(crate) mod tests;

use ndarray::Array2;
use pocketnerf_core::Ray;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::network::{Adam, Dense, Layout, Lstm, Mlp, Moments};
use crate::photographs::{Batch, Photographs, Place};
use crate::run::At;

/// Rays of a step.
const RAYS: usize = 512;
/// Rays that are worked on together; sums of gradients follow this order.
const GROUP: usize = 128;
/// Learning rate at first and in the end.
const RATES: [f32; 2] = [4e-4, 5e-5];

/// The networks' sizes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Config {
    /// Features, and units of a layer.
    pub(crate) width: u32,
    /// Values that the marcher remembers.
    pub(crate) hidden: u32,
    /// Steps along a ray.
    pub(crate) steps: u32,
}

impl Default for Config {
    /// Half as wide as published.
    fn default() -> Self {
        Self { width: 128, hidden: 16, steps: 10 }
    }
}

impl Config {
    /// Sizes that a file may have.
    pub(crate) fn is_sound(&self) -> bool {
        (1..=1024).contains(&self.width)
            && (1..=256).contains(&self.hidden)
            && (1..=64).contains(&self.steps)
    }
}

/// Layers of the network of points.
const POINT_LAYERS: usize = 4;
/// Layers of the network of colours, the last one not counted.
const COLOR_LAYERS: usize = 4;

/// The networks, without their parameters.
#[derive(Clone, Debug)]
pub(crate) struct Networks {
    config: Config,
    layout: Layout,
    points: Mlp,
    memory: Lstm,
    length: Dense,
    colors: Mlp,
    out: Dense,
}

impl Networks {
    pub(crate) fn new(config: Config) -> Self {
        let [width, hidden] = [config.width, config.hidden].map(|n| n as usize);
        let mut layout = Layout::default();
        let points = Mlp::new(&mut layout, 3, width, POINT_LAYERS);
        let memory = Lstm::new(&mut layout, width, hidden);
        let length = Dense::new(&mut layout, hidden, 1, 0.5_f64.sqrt());
        let colors = Mlp::new(&mut layout, width, width, COLOR_LAYERS);
        let out = Dense::new(&mut layout, width, 3, 0.5_f64.sqrt());
        Self { config, layout, points, memory, length, colors, out }
    }

    /// Number of parameters.
    pub(crate) fn len(&self) -> usize {
        self.layout.len()
    }
}

/// What was learnt.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Srn {
    pub(crate) config: Config,
    pub(crate) parameters: Vec<f32>,
}

impl Srn {
    /// Whether the numbers fit each other.
    pub(crate) fn is_sound(&self) -> bool {
        self.config.is_sound()
            && self.parameters.len() == Networks::new(self.config).len()
            && self.parameters.iter().all(|p| p.is_finite())
    }

    /// Colours of rays, sRGB.
    pub(crate) fn colors(&self, networks: &Networks, place: &Place, rays: &[Ray]) -> Vec<[f32; 3]> {
        let colors = networks.forward(&self.parameters, place, rays).colors;
        colors.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect()
    }
}

/// Training in progress.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Training {
    pub(crate) srn: Srn,
    moments: Moments,
}

impl Training {
    pub(crate) fn new(seed: u64) -> Self {
        let config = Config::default();
        let networks = Networks::new(config);
        let mut parameters: Vec<f32> = networks.layout.init(seed);
        networks.memory.open(&mut parameters);
        // At first rays end near the middle of the scene.
        let length = march::BEFORE / config.steps as f32;
        parameters[networks.length.biases()].fill(length);
        let moments = Moments::new(parameters.len());
        Self { srn: Srn { config, parameters }, moments }
    }

    pub(crate) fn is_sound(&self) -> bool {
        self.srn.is_sound() && self.moments.len() == self.srn.parameters.len()
    }

    /// One step; gives the mean squared error of its rays.
    pub(crate) fn step(&mut self, photographs: &Photographs, at: At) -> f64 {
        let networks = Networks::new(self.srn.config);
        let batch = photographs.batch(RAYS, at.seed, at.step);
        let (error, gradient) = networks.gradient(&self.srn.parameters, &photographs.place, &batch);
        let rate = at.between(RATES);
        self.moments.step(Adam::default(), rate, &mut self.srn.parameters, &gradient);
        error
    }
}

impl Networks {
    /// The mean squared error of a batch, and the gradient of the loss.
    fn gradient(&self, parameters: &[f32], place: &Place, batch: &Batch) -> (f64, Vec<f32>) {
        let groups = batch.rays.par_chunks(GROUP).zip(batch.colors.par_chunks(GROUP));
        let parts: Vec<(f64, Vec<f32>)> = groups
            .map(|(rays, colors)| {
                let mut gradient = vec![0.0; self.len()];
                let pass = self.forward(parameters, place, rays);
                let n = batch.rays.len() as f32;
                let difference = Array2::from_shape_fn((rays.len(), 3), |(i, c)| {
                    pass.colors[[i, c]] - colors[i][c]
                });
                let error = difference.iter().map(|d| f64::from(d * d)).sum::<f64>();
                self.backward(
                    parameters,
                    &pass,
                    &(difference * (2.0 / (3.0 * n))),
                    1.0 / n,
                    &mut gradient,
                );
                (error, gradient)
            })
            .collect();
        let mut sum = vec![0.0; self.len()];
        let mut error = 0.0;
        for (part, gradient) in parts {
            error += part;
            sum.iter_mut().zip(gradient).for_each(|(sum, g)| *sum += g);
        }
        (error / (3 * batch.rays.len()) as f64, sum)
    }
}
