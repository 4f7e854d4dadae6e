//! Layers as scene representation networks have them: dense, normalised (Ba et al. 2016), ReLU.

use ndarray::{Array2, ArrayView2, Zip};

use super::{Dense, Layout, Real};

/// Keeps the division finite.
const EPSILON: f64 = 1e-5;

/// A dense layer whose outputs are normalised, sample by sample, and rectified.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    dense: Dense,
}

/// What the way back needs.
#[derive(Debug)]
pub(crate) struct BlockTape<T> {
    input: Array2<T>,
    /// Normalised outputs, before they are rectified.
    normalized: Array2<T>,
    /// One over the standard deviation of each sample.
    scale: Vec<T>,
}

impl Block {
    pub(crate) fn new(layout: &mut Layout, inputs: usize, outputs: usize) -> Self {
        Self { dense: Dense::new(layout, inputs, outputs, 1.0) }
    }

    pub(crate) fn forward<T: Real>(
        &self,
        parameters: &[T],
        input: Array2<T>,
    ) -> (Array2<T>, BlockTape<T>) {
        let mut normalized = self.dense.forward(parameters, &input.view());
        let mut scale = Vec::with_capacity(normalized.nrows());
        for mut row in normalized.rows_mut() {
            let n = T::of(row.len() as f64);
            let mean = row.sum() / n;
            let variance = row.iter().map(|v| (*v - mean) * (*v - mean)).sum::<T>() / n;
            let inverse = (variance + T::of(EPSILON)).sqrt().recip();
            row.mapv_inplace(|v| (v - mean) * inverse);
            scale.push(inverse);
        }
        let output = normalized.mapv(|v| v.max(T::zero()));
        (output, BlockTape { input, normalized, scale })
    }

    /// Adds to the parameters' gradient, and gives that of the input.
    pub(crate) fn backward<T: Real>(
        &self,
        parameters: &[T],
        tape: &BlockTape<T>,
        dy: &ArrayView2<'_, T>,
        gradient: &mut [T],
    ) -> Array2<T> {
        let mut d = dy.to_owned();
        Zip::from(&mut d).and(&tape.normalized).for_each(|d, y| {
            if *y <= T::zero() {
                *d = T::zero();
            }
        });
        let rows = d.rows_mut().into_iter().zip(tape.normalized.rows()).zip(&tape.scale);
        for ((mut d, y), scale) in rows {
            let n = T::of(d.len() as f64);
            let mean = d.sum() / n;
            let along = d.iter().zip(&y).map(|(d, y)| *d * *y).sum::<T>() / n;
            Zip::from(&mut d).and(&y).for_each(|d, y| *d = (*d - mean - along * *y) * *scale);
        }
        self.dense.backward(parameters, &tape.input.view(), &d.view(), gradient)
    }
}

/// Blocks one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Mlp {
    blocks: Vec<Block>,
}

/// What the way back needs.
pub(crate) type MlpTape<T> = Vec<BlockTape<T>>;

impl Mlp {
    /// So many blocks, all but the input equally wide.
    pub(crate) fn new(layout: &mut Layout, inputs: usize, width: usize, blocks: usize) -> Self {
        let inputs = |i| if i == 0 { inputs } else { width };
        Self { blocks: (0..blocks).map(|i| Block::new(layout, inputs(i), width)).collect() }
    }

    pub(crate) fn forward<T: Real>(
        &self,
        parameters: &[T],
        mut x: Array2<T>,
    ) -> (Array2<T>, MlpTape<T>) {
        let mut tapes = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let (y, tape) = block.forward(parameters, x);
            tapes.push(tape);
            x = y;
        }
        (x, tapes)
    }

    /// Adds to the parameters' gradient, and gives that of the input.
    pub(crate) fn backward<T: Real>(
        &self,
        parameters: &[T],
        tapes: &MlpTape<T>,
        dy: Array2<T>,
        gradient: &mut [T],
    ) -> Array2<T> {
        let layers = self.blocks.iter().zip(tapes).rev();
        layers.fold(dy, |d, (block, tape)| block.backward(parameters, tape, &d.view(), gradient))
    }
}
