//! Neural volumes (Lombardi et al. 2019): a network makes a cube of colours and opacities of a
//! code, and a mixture of affine maps that bends it; rays add up what they meet.

mod decoder;
mod deconvolution;
mod grid;
mod loss;
mod march;
mod networks;
#[cfg(test)]
pub(crate) mod tests;
mod warp;

use pocketnerf_core::Ray;
use pocketnerf_train::random::Random;
use serde::{Deserialize, Serialize};

use crate::network::{Adam, Moments};
use crate::photographs::{Photographs, Place};
use crate::run::At;
use loss::loss;
use march::Volume;
use networks::{Config, Networks};

/// Rays of a step.
const RAYS: usize = 4096;
/// Learning rate at first and in the end.
const RATES: [f32; 2] = [2e-3, 1e-4];
/// What was learnt.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct NeuralVolume {
    config: Config,
    parameters: Vec<f32>,
}

impl NeuralVolume {
    /// Whether the numbers fit each other.
    pub(crate) fn is_sound(&self) -> bool {
        self.config.is_sound()
            && self.parameters.len() == Networks::new(self.config).layout.len()
            && self.parameters.iter().all(|p| p.is_finite())
    }

    /// Numbers that were learnt.
    pub(crate) fn values(&self) -> usize {
        self.parameters.len()
    }

    /// Its volume.
    pub(crate) fn prepare(&self) -> Prepared {
        Prepared { volume: Networks::new(self.config).decode(&self.parameters).0 }
    }
}

/// A volume to render.
#[derive(Debug)]
pub(crate) struct Prepared {
    volume: Volume<f32>,
}

impl Prepared {
    /// Premultiplied sRGB and opacity of a ray.
    pub(crate) fn color(&self, place: &Place, ray: &Ray) -> [f32; 4] {
        self.volume.march(place, ray, 0.5).rgba
    }
}

/// Training in progress.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Training {
    volume: NeuralVolume,
    moments: Moments,
}

/// The purpose of random offsets of samples.
const OFFSET: u64 = 13;

impl Training {
    pub(crate) fn new(seed: u64) -> Self {
        let config = Config::default();
        let parameters: Vec<f32> = Networks::new(config).layout.init(seed);
        let moments = Moments::new(parameters.len());
        Self { volume: NeuralVolume { config, parameters }, moments }
    }

    /// The result so far.
    pub(crate) fn scene(&self) -> NeuralVolume {
        self.volume.clone()
    }

    pub(crate) fn is_sound(&self) -> bool {
        self.volume.is_sound() && self.moments.len() == self.volume.parameters.len()
    }

    /// One step; gives the mean squared error of its rays.
    pub(crate) fn step(&mut self, photographs: &Photographs, at: At) -> f64 {
        let networks = Networks::new(self.volume.config);
        let parameters = &mut self.volume.parameters;
        let batch = photographs.batch(RAYS, at.seed, at.step);
        let (volume, tape) = networks.decode(parameters);
        let offset = |i: usize| Random::new(at.seed, [OFFSET, at.step.into(), i as u64]).next_f32();
        let (_, error, d) = loss(&volume, &photographs.place, &batch, offset);
        let gradient = networks.backward(parameters, &tape, d);
        self.moments.step(Adam::default(), at.between(RATES), parameters, &gradient);
        error
    }
}
