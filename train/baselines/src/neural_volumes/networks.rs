//! The networks: from a code to the template and to what bends it, there and back.

use ndarray::Array2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::decoder::{Decoder, DecoderTape};
use super::grid::Grid;
use super::march::Volume;
use super::warp::{AFFINE, Mixture};
use crate::network::{Dense, Layout, Real};

/// Opacities a half side are this times what softplus makes of the network's values...
const DENSITY: f64 = 16.0;
/// ... after this is subtracted: clouds are thin at first.
const THIN: f64 = 4.0;
/// Gain of last layers: at first all places are nearly alike. Where some are opaque from the start,
/// nothing behind them is learnt.
const EVEN: f64 = 0.1;

/// Sizes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Config {
    /// Values of the code.
    pub(super) code: u32,
    /// Channels of the first cube of the template's network: half as many in each further one.
    pub(super) channels: u32,
    /// How often the template's side of 4 is doubled.
    pub(super) doublings: u32,
    /// How often that of the weights of maps is.
    pub(super) warp_doublings: u32,
    /// Affine maps.
    pub(super) maps: u32,
}

impl Default for Config {
    /// Cubes of half the published side.
    fn default() -> Self {
        Self { code: 64, channels: 64, doublings: 4, warp_doublings: 3, maps: 16 }
    }
}

impl Config {
    /// Sizes that a file may have.
    pub(super) fn is_sound(&self) -> bool {
        (1..=256).contains(&self.code)
            && (1..=128).contains(&self.channels)
            && (1..=5).contains(&self.doublings)
            && (1..=4).contains(&self.warp_doublings)
            && (1..=32).contains(&self.maps)
    }
}

/// The networks, without their parameters.
#[derive(Clone, Debug)]
pub(super) struct Networks {
    pub(super) layout: Layout,
    code: std::ops::Range<usize>,
    template: Decoder,
    weights: Decoder,
    maps: Dense,
}

/// What the way back needs.
pub(super) struct Tape<T> {
    code: Array2<T>,
    template: DecoderTape<T>,
    /// What the network gave, before its functions.
    raw: Grid<T>,
    weights_tape: DecoderTape<T>,
    weights: Grid<T>,
    maps: Vec<[T; AFFINE]>,
}

impl Networks {
    pub(super) fn new(config: Config) -> Self {
        let [code, channels, maps] =
            [config.code, config.channels, config.maps].map(|n| n as usize);
        let mut layout = Layout::default();
        let range = layout.add(code, 0.0, 1.0);
        let halved = |times: u32, last: usize| -> Vec<usize> {
            let between = (0..times).map(|i| (channels >> i).max(16.min(channels)));
            between.chain([last]).collect()
        };
        let template = Decoder::new(&mut layout, code, &halved(config.doublings, 4), EVEN);
        let weights = Decoder::new(&mut layout, code, &halved(config.warp_doublings, maps), EVEN);
        let maps = Dense::new(&mut layout, code, maps * AFFINE, 0.01);
        Self { layout, code: range, template, weights, maps }
    }

    /// The volume of these parameters.
    pub(super) fn decode<T: Real>(&self, parameters: &[T]) -> (Volume<T>, Tape<T>) {
        let code = parameters[self.code.clone()].to_vec();
        let code = Array2::from_shape_vec((1, code.len()), code).expect("one row");
        let (raw, template) = self.template.forward(parameters, &code);
        let mut colored = raw.clone();
        colored.values.par_chunks_mut(4).for_each(|values| {
            for value in &mut values[..3] {
                *value = value.sigmoid();
            }
            values[3] = T::of(DENSITY) * (values[3] - T::of(THIN)).softplus();
        });
        let (mut weights, weights_tape) = self.weights.forward(parameters, &code);
        weights.values.par_iter_mut().for_each(|value| *value = value.exp());
        let flat = self.maps.forward(parameters, &code.view());
        let mut maps: Vec<[T; AFFINE]> =
            flat.as_slice().expect("one row").as_chunks::<AFFINE>().0.to_vec();
        for map in &mut maps {
            // Nothing is moved at first.
            [0, 5, 10].into_iter().for_each(|i| map[i] += T::one());
        }
        let warp = Mixture { maps: &maps, weights: &weights }.field(weights.side);
        let tape = Tape { code, template, raw, weights_tape, weights, maps };
        (Volume { template: colored, warp }, tape)
    }

    /// From the volume's gradient to that of the parameters.
    pub(super) fn backward<T: Real>(
        &self,
        parameters: &[T],
        tape: &Tape<T>,
        d: Volume<T>,
    ) -> Vec<T> {
        let mut gradient = vec![T::zero(); self.layout.len()];
        let mut d_code = Array2::zeros(tape.code.raw_dim());
        let mut d_raw = d.template;
        d_raw.values.par_chunks_mut(4).zip(tape.raw.values.par_chunks(4)).for_each(|(d, raw)| {
            for (d, raw) in d[..3].iter_mut().zip(raw) {
                let value = raw.sigmoid();
                *d *= value * (T::one() - value);
            }
            d[3] *= T::of(DENSITY) * (raw[3] - T::of(THIN)).sigmoid();
        });
        let code = &tape.code;
        let cubes = (code, &tape.template);
        self.template.backward(parameters, cubes, d_raw, &mut gradient, &mut d_code);
        let mixture = Mixture { maps: &tape.maps, weights: &tape.weights };
        let (d_maps, mut d_weights) = mixture.backward(&d.warp);
        // The weights are exponentials.
        let pairs = d_weights.values.par_iter_mut().zip(&tape.weights.values);
        pairs.for_each(|(d, weight)| *d *= *weight);
        let cubes = (code, &tape.weights_tape);
        self.weights.backward(parameters, cubes, d_weights, &mut gradient, &mut d_code);
        let d_maps =
            Array2::from_shape_vec((1, d_maps.len() * AFFINE), d_maps.as_flattened().to_vec())
                .expect("one row");
        d_code += &self.maps.backward(parameters, &code.view(), &d_maps.view(), &mut gradient);
        let own = &mut gradient[self.code.clone()];
        own.iter_mut().zip(&d_code).for_each(|(g, d)| *g += *d);
        gradient
    }
}
