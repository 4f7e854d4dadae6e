//! The parameters as the forward pass of training reads them: about as the model
//! file will hold them.
//!
//! What is learnt is learnt for the rounded values, and tables take a quarter of
//! the cache. The optimizer keeps the parameters themselves in `f32`.

use fearless_simd::{Level, dispatch};

use super::rounding::{EightBits, Half, Rounding};
use super::{Layout, Range};
use crate::aligned::Aligned;

/// All parameters, rounded.
#[derive(Debug)]
pub struct Rounded {
    /// The grid's levels, one after another.
    pub(crate) tables: Aligned<u8>,
    /// How each level is rounded.
    pub(crate) scales: Vec<EightBits>,
    /// The networks.
    pub(crate) networks: Aligned<u16>,
}

impl Rounded {
    /// Zeros.
    #[must_use]
    pub fn new(layout: &Layout) -> Self {
        let start = layout.networks_start();
        Self {
            tables: Aligned::new(start),
            scales: vec![EightBits::FINEST; layout.levels().len()],
            networks: Aligned::new(layout.len() - start),
        }
    }

    /// How each level is rounded.
    pub fn scales(&self) -> impl Iterator<Item = EightBits> {
        self.scales.iter().copied()
    }

    /// Rounds all `parameters`: each level as finely as holds all of it.
    pub fn round(&mut self, simd: Level, layout: &Layout, parameters: &[f32]) {
        let scale = |range: &Range| {
            let mut scale = EightBits::FINEST;
            let level = &parameters[range.indices()];
            scale.hold(level.iter().fold(0.0, |most, v| v.abs().max(most)));
            scale
        };
        let scales: Vec<EightBits> = layout.levels().iter().map(scale).collect();
        self.round_tables(simd, layout, &scales, parameters);
        let networks = &parameters[layout.networks_start()..];
        dispatch!(simd, simd => Half.round_all(simd, networks, &mut self.networks));
    }

    /// Rounds the tables among `parameters` with these scales, one a level.
    pub fn round_tables(
        &mut self,
        simd: Level,
        layout: &Layout,
        scales: &[EightBits],
        parameters: &[f32],
    ) {
        self.scales.copy_from_slice(scales);
        for (scale, range) in scales.iter().zip(layout.levels()) {
            let (from, to) = (&parameters[range.indices()], &mut self.tables[range.indices()]);
            dispatch!(simd, simd => scale.round_all(simd, from, to));
        }
    }
}
