//! Models of at most so many bytes.
//!
//! Once parameters begin to be averaged, it is known what each level of the tables is worth:
//! steps are chosen as for a finished model (see [`compact`]), and from then on
//! training reads tables rounded to them, so that networks and entries get used to it. The finished
//! model has the same steps, or shorter ones where there is room; if they do not fit after all,
//! they are chosen anew.

use std::time::Instant;

use pocketnerf_core::{Camera, Error, Model};
use pocketnerf_formats::{About, Precision, pack, write};

use crate::compact::pictures::Pictures;
use crate::compact::{self, CompactError, Compacted};
use crate::field::rounding::EightBits;
use crate::picture::Settings;
use crate::trainer::held_out::HeldOut;
use crate::trainer::{HeldOutPsnr, Trainer};

/// What else a file holds beside networks, at least, bytes.
const REST: usize = 2048;
/// Cells that become half as wide take so many times as many bytes more.
const FINER: usize = 3;

impl Trainer {
    /// How close a model comes to the views that are held out, if there are any.
    ///
    /// # Errors
    /// Whatever rendering reports.
    pub fn held_out_psnr(&self, model: &Model<'_>) -> Result<Option<HeldOutPsnr>, Error> {
        self.held_out.look(model, self.backend.simd())
    }

    /// The cameras and settings with which small models are compared.
    pub(crate) fn compared(&self, side: u32) -> (Vec<Camera>, Settings) {
        let cameras = compact::small(self.source.cameras().to_vec(), side);
        (cameras, Settings { simd: self.backend.simd(), ..Settings::default() })
    }

    /// A model file in at most so many bytes.
    pub(crate) fn in_bytes(
        &self,
        file: &[u8],
        most: u32,
        side: u32,
    ) -> Result<Compacted, CompactError> {
        let (cameras, settings) = self.compared(side);
        let lengths = self.coarse_lengths();
        compact::to_bytes(file, most as usize, lengths.as_deref(), &cameras, &settings)
    }

    /// Seconds that finding a model's size takes, about, if pictures of this size are
    /// compared.
    pub(crate) fn time_of_sizing(&self, side: u32) -> Result<f64, CompactError> {
        let model = self.model();
        let (cameras, settings) = self.compared(side);
        let clock = Instant::now();
        Pictures::of(&model, &cameras, &settings)?;
        let looked = clock.elapsed().as_secs_f64();
        pack(&write(&model, &About::default(), Precision::I8)?)?;
        let packed = clock.elapsed().as_secs_f64() - looked;
        let [looks, packs] = compact::work(self.config.field.kind().layout().tables().len());
        Ok(looks as f64 * looked + packs as f64 * packed)
    }

    /// How many views are held out, or will be once the run begins.
    #[must_use]
    pub fn n_to_hold_out(&self) -> usize {
        if self.step > 0 {
            return self.held_out.len();
        }
        HeldOut::choose(&self.source, self.config.seed).len()
    }

    /// Bytes of its networks at four bits a value: no model of this shape takes less.
    #[must_use]
    pub fn least_bytes(&self) -> usize {
        let layout = self.config.field.kind().layout();
        REST + (layout.len() - layout.networks_start()) / 2
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
    pub(crate) fn fit_into(&mut self, most: u32, side: u32) {
        let n = self.config.field.kind().layout().tables().len();
        let lengths = self.lengths(most, side).unwrap_or_else(|_| vec![0.0; n]);
        self.backend.round_coarsely(&lengths);
    }

    /// The lengths of the steps.
    fn lengths(&self, most: u32, side: u32) -> Result<Vec<f32>, CompactError> {
        let file = |model: &Model<'_>| write(model, &About::default(), Precision::I8);
        let model = self.model();
        let whole = file(&model)?;
        let without = pack(&file(&Model { occupancy: None, ..model })?)?.len();
        let cells = pack(&whole)?.len().saturating_sub(without);
        let most = most.saturating_sub(u32::try_from(FINER * cells).unwrap_or(u32::MAX));
        Ok(self.in_bytes(&whole, most, side)?.lengths)
    }
}
