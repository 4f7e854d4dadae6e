//! Models of at most so many bytes.
//!
//! Once parameters begin to be averaged, it is known what each level of the tables is worth:
//! steps are chosen as for a finished model (see [`compact`]), and from then on
//! training reads tables rounded to them, so that networks and entries get used to it. The finished
//! model has the same steps, or shorter ones where there is room; if they do not fit after all,
//! they are chosen anew.

use pocketnerf_core::Model;
use pocketnerf_formats::{About, Precision, pack, write};

use crate::compact::{self, CompactError, Compacted};
use crate::field::rounding::EightBits;
use crate::picture::Settings;
use crate::trainer::Trainer;

/// What else a file holds beside networks in f16, at least, bytes.
const REST: usize = 2048;
/// Cells that become half as wide take so many times as many bytes more.
const FINER: usize = 3;

impl Trainer {
    /// A model file in at most so many bytes.
    ///
    /// # Errors
    /// As [`compact::to_bytes`].
    pub fn in_bytes(&self, file: &[u8], most: usize) -> Result<Compacted, CompactError> {
        let cameras = compact::small(self.source.cameras().to_vec());
        let settings = Settings { simd: self.backend.simd(), ..Settings::default() };
        compact::to_bytes(file, most, self.coarse_lengths().as_deref(), &cameras, &settings)
    }

    /// Bytes of its networks: no model of this shape takes less.
    #[must_use]
    pub fn least_bytes(&self) -> usize {
        let layout = self.config.field.kind().layout();
        REST + 2 * (layout.len() - layout.networks_start())
    }

    /// Whether tables are rounded as coarsely as few bytes ask for.
    pub(crate) fn is_coarse(&self) -> bool {
        self.coarse_lengths().is_some()
    }

    /// The steps that tables are rounded to, where few bytes ask for them.
    pub(crate) fn coarse_lengths(&self) -> Option<Vec<f32>> {
        let n = self.config.field.kind().layout().tables().len();
        let (scales, coarse) = EightBits::all_of(&self.backend.download().scales, n)?;
        coarse.then(|| scales.into_iter().map(EightBits::length).collect())
    }

    /// From now on tables are rounded as a model of so many bytes asks for. Where none is that
    /// small, they stay as they are; the finished model tells.
    pub(crate) fn fit_into(&mut self, most: usize) {
        let n = self.config.field.kind().layout().tables().len();
        let lengths = self.lengths(most).unwrap_or_else(|_| vec![0.0; n]);
        self.backend.round_coarsely(&lengths);
    }

    /// The lengths of the steps.
    fn lengths(&self, most: usize) -> Result<Vec<f32>, CompactError> {
        let file = |model: &Model<'_>| write(model, &About::default(), Precision::I8);
        let model = self.model();
        let whole = file(&model)?;
        let without = pack(&file(&Model { occupancy: None, ..model })?)?.len();
        let cells = pack(&whole)?.len().saturating_sub(without);
        Ok(self.in_bytes(&whole, most.saturating_sub(FINER * cells))?.lengths)
    }
}
