//! From a code to a cube of values: a dense layer, then cubes that double their side.

use ndarray::{Array2, Axis};

use super::deconvolution::Deconvolution;
use super::grid::Grid;
use crate::network::{Dense, Layout, Real};

/// Side of the first cube.
const FIRST: usize = 4;
/// What a negative value is multiplied by between layers.
const LEAK: f64 = 0.2;

/// Layers from a code to a cube.
#[derive(Clone, Debug)]
pub(super) struct Decoder {
    dense: Dense,
    /// Channels of the first cube.
    channels: usize,
    layers: Vec<Deconvolution>,
}

/// Cubes before each layer, after its rectifier.
#[derive(Debug)]
pub(super) struct DecoderTape<T> {
    cubes: Vec<Grid<T>>,
}

impl Decoder {
    /// `channels` of the cubes, the first one's and each layer's; `gain` of the last layer.
    pub(super) fn new(layout: &mut Layout, code: usize, channels: &[usize], gain: f64) -> Self {
        let dense = Dense::new(layout, code, channels[0] * FIRST.pow(3), 1.0);
        let last = channels.len() - 2;
        let layers = channels.windows(2).enumerate().map(|(i, pair)| {
            Deconvolution::new(layout, pair[0], pair[1], if i == last { gain } else { 1.0 })
        });
        Self { dense, channels: channels[0], layers: layers.collect() }
    }

    pub(super) fn forward<T: Real>(
        &self,
        parameters: &[T],
        code: &Array2<T>,
    ) -> (Grid<T>, DecoderTape<T>) {
        let first = self.dense.forward(parameters, &code.view());
        let values = first.into_raw_vec_and_offset().0;
        let mut cube = Grid { side: FIRST, channels: self.channels, values };
        let mut cubes = Vec::with_capacity(self.layers.len());
        for layer in &self.layers {
            cube.values.iter_mut().for_each(|v| *v = v.max(*v * T::of(LEAK)));
            let next = layer.forward(parameters, &cube);
            cubes.push(std::mem::replace(&mut cube, next));
        }
        (cube, DecoderTape { cubes })
    }

    /// Adds to the gradients of the parameters and of the code.
    pub(super) fn backward<T: Real>(
        &self,
        parameters: &[T],
        (code, tape): (&Array2<T>, &DecoderTape<T>),
        d: Grid<T>,
        gradient: &mut [T],
        d_code: &mut Array2<T>,
    ) {
        let mut d = d;
        for (layer, cube) in self.layers.iter().zip(&tape.cubes).rev() {
            d = layer.backward(parameters, cube, &d, gradient);
            d.values.iter_mut().zip(&cube.values).for_each(|(d, v)| {
                if *v < T::zero() {
                    *d *= T::of(LEAK);
                }
            });
        }
        let d = Array2::from_shape_vec((1, d.values.len()), d.values).expect("one row");
        *d_code += &self.dense.backward(parameters, &code.view(), &d.view(), gradient);
        debug_assert_eq!(d_code.len_of(Axis(0)), 1, "one code");
    }
}
