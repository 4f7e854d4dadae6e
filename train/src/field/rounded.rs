//! The parameters as the forward pass of training reads them: about as the model
//! file will hold them.
//!
//! What is learnt is learnt for the rounded values, and tables take a quarter of
//! the cache. The optimizer keeps the parameters themselves in `f32`.

use fearless_simd::{Level, dispatch};
use pocketnerf_core::{DType, Error, TensorView};

use super::layout::{Layout, Range, Role};
use super::rounding::{EightBits, Half, Rounding};
use crate::aligned::Aligned;

/// All parameters of a field, rounded.
#[derive(Debug)]
pub struct Rounded {
    /// The tables, one after another.
    pub(crate) tables: Aligned<u8>,
    /// How each table is rounded.
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
            scales: vec![EightBits::FINEST; layout.tables().len()],
            networks: Aligned::new(layout.len() - start),
        }
    }

    /// Rounds all `parameters`: each table as finely as holds all of it.
    pub fn round(&mut self, simd: Level, layout: &Layout, parameters: &[f32]) {
        let scale = |range: &Range| {
            let mut scale = EightBits::FINEST;
            let table = &parameters[range.indices()];
            scale.hold(table.iter().fold(0.0, |most, v| v.abs().max(most)));
            scale
        };
        let scales: Vec<EightBits> = layout.tables().iter().map(scale).collect();
        self.round_tables(simd, layout, &scales, parameters);
        let networks = &parameters[layout.networks_start()..];
        dispatch!(simd, simd => Half.round_all(simd, networks, &mut self.networks));
    }

    /// Rounds the tables among `parameters` with these scales, one a table.
    pub fn round_tables(
        &mut self,
        simd: Level,
        layout: &Layout,
        scales: &[EightBits],
        parameters: &[f32],
    ) {
        self.scales.copy_from_slice(scales);
        for (scale, range) in scales.iter().zip(layout.tables()) {
            let (from, to) = (&parameters[range.indices()], &mut self.tables[range.indices()]);
            dispatch!(simd, simd => scale.round_all(simd, from, to));
        }
    }

    /// What a checkpoint holds of how tables are rounded: exponents of units, and, where they are
    /// rounded coarsely, steps.
    #[must_use]
    pub fn scales(&self, coarse: bool) -> Vec<u8> {
        let scales = self.scales.iter();
        let units = scales.clone().map(|scale| scale.scale_log2().cast_unsigned());
        units.chain(scales.map(|scale| scale.step()).filter(|_| coarse)).collect()
    }

    /// Rounds the tables as [`scales`](Self::scales) says, and gives whether coarsely; `None` for
    /// bytes that it never gives.
    pub fn restore_scales(
        &mut self,
        simd: Level,
        layout: &Layout,
        scales: &[u8],
        parameters: &[f32],
    ) -> Option<bool> {
        let (scales, coarse) = EightBits::all_of(scales, self.scales.len())?;
        self.round_tables(simd, layout, &scales, parameters);
        Some(coarse)
    }

    /// A range of the layout as a tensor.
    ///
    /// # Errors
    /// Whatever core's validation reports.
    pub fn tensor(&self, range: &Range) -> Result<TensorView<'_>, Error> {
        if range.part.role == Role::Table {
            let scale = self.scales[range.part.layer].scale_log2();
            return range.tensor(&self.tables[range.indices()], DType::I8, scale);
        }
        let values = &self.networks[range.start - self.tables.len()..][..range.len()];
        range.tensor(bytemuck::must_cast_slice(values), DType::F16, Half::SCALE_LOG2)
    }
}
