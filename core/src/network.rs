//! Small dense networks: layers with ReLU between them and none after the last.

use crate::{Error, TensorView};

/// Most layers a network may have.
pub const MAX_LAYERS: usize = 10;

/// `y = W x + b`.
#[derive(Clone, Copy, Debug)]
pub struct Dense<'a> {
    /// `[n_in, n_out]`: input-major, so that the outputs of one input lie together.
    pub weight: TensorView<'a>,
    /// `[1, n_out]`; `None`: no bias.
    pub bias: Option<TensorView<'a>>,
}

impl Dense<'_> {
    /// The placeholder in fixed-size arrays.
    pub const EMPTY: Dense<'static> = Dense { weight: TensorView::EMPTY, bias: None };
}

/// A network of dense layers.
#[derive(Clone, Copy, Debug)]
pub struct Mlp<'a> {
    layers: [Dense<'a>; MAX_LAYERS],
    n_layers: usize,
}

impl<'a> Mlp<'a> {
    /// Checks that the layers fit onto one another.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn new(layers: &[Dense<'a>]) -> Result<Self, Error> {
        if layers.is_empty() || layers.len() > MAX_LAYERS {
            return Err(Error::Range("network: number of layers"));
        }
        for layer in layers {
            let [n_in, n_out] = layer.weight.shape();
            if n_in == 0 || n_out == 0 || n_in > 4096 || n_out > 4096 {
                return Err(Error::Range("network: width of a layer"));
            }
            if layer.weight.dtype() != layers[0].weight.dtype() {
                return Err(Error::Shape("network: layers of different types"));
            }
            if let Some(bias) = layer.bias
                && (bias.shape() != [1, n_out] || bias.dtype() != layer.weight.dtype())
            {
                return Err(Error::Shape("network: a bias and its layer"));
            }
        }
        for pair in layers.windows(2) {
            if pair[0].weight.cols() != pair[1].weight.rows() {
                return Err(Error::Shape("network: a layer and the next"));
            }
        }
        let mut all = [Dense::EMPTY; MAX_LAYERS];
        all[..layers.len()].copy_from_slice(layers);
        Ok(Self { layers: all, n_layers: layers.len() })
    }

    /// The layers, first to last.
    #[must_use]
    pub fn layers(&self) -> &[Dense<'a>] {
        &self.layers[..self.n_layers]
    }

    /// Values read.
    #[must_use]
    pub fn n_input(&self) -> usize {
        self.layers[0].weight.rows()
    }

    /// Values given.
    #[must_use]
    pub fn n_output(&self) -> usize {
        self.layers[self.n_layers - 1].weight.cols()
    }

    /// The widest layer's width, inputs and outputs included.
    #[must_use]
    pub fn max_width(&self) -> usize {
        self.layers().iter().map(|l| l.weight.rows().max(l.weight.cols())).max().unwrap_or(0)
    }
}
