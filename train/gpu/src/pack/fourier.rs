//! Fourier features, in whole quads.

use alloc::vec::Vec;

use pocketnerf_core::encoding::{Fourier, Waves};

use super::layer::{QUAD, Weights, padded};

/// Fourier features as the shader has them.
#[derive(Debug)]
pub(crate) struct PackedFourier {
    pub(crate) include_input: bool,
    pub(crate) waves: PackedWaves,
    /// Which value of the encoding each of the shader's is.
    pub(crate) order: Vec<Option<usize>>,
    /// Values of the encoding itself.
    pub(crate) n_output: usize,
}

#[derive(Debug)]
pub(crate) enum PackedWaves {
    /// Two quads an octave: three sines, three cosines.
    Octaves { n: u32, pi: bool },
    /// Quads of cosines, then as many of sines. Frequencies are rows of the weights.
    Gaussian { first: usize, n: usize },
}

pub(super) fn pack(fourier: &Fourier<'_>, weights: &mut Weights) -> PackedFourier {
    let mut order = Vec::new();
    let mut at = 0;
    let mut next = |n: usize| {
        at += n;
        padded(at - n..at)
    };
    if fourier.include_input {
        order.extend(next(3));
    }
    let waves = match &fourier.waves {
        Waves::Octaves { n, pi } => {
            (0..2 * n).for_each(|_| order.extend(next(3)));
            PackedWaves::Octaves { n: *n, pi: *pi }
        }
        Waves::Gaussian(matrix) => {
            let (first, n) = (weights.rows.len(), matrix.cols());
            for f in 0..n.next_multiple_of(QUAD) {
                let value = |row: usize| if f < n { matrix.get(row * n + f) } else { 0.0 };
                weights.rows.push([value(0), value(1), value(2), 0.0]);
            }
            (0..2).for_each(|_| order.extend(next(n)));
            PackedWaves::Gaussian { first, n }
        }
    };
    let (include_input, n_output) = (fourier.include_input, fourier.n_output());
    PackedFourier { include_input, waves, order, n_output }
}

impl PackedFourier {
    /// Quads of an encoded point.
    pub(crate) const fn quads(&self) -> usize {
        self.order.len() / QUAD
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_by_hand() {
        // x, y, z; two octaves of three sines and three cosines.
        let waves = Waves::Octaves { n: 2, pi: false };
        let packed = pack(&Fourier { waves, include_input: true }, &mut Weights::default());
        let quad = |first: usize| [Some(first), Some(first + 1), Some(first + 2), None];
        assert_eq!(packed.order, [0, 3, 6, 9, 12].map(quad).concat());
        assert_eq!((packed.n_output, packed.quads()), (15, 5));
    }
}
