//! A decomposed field (Rebain et al. 2021, "DeRF"), trainable: a small vanilla NeRF for each part
//! of the scene.
//!
//! Parts are learnt before the first step, from the cells that hold something
//! (`sites`); then each head learns from its own samples alone.

mod back;
mod config;
mod sites;
#[cfg(test)]
mod tests;

use std::sync::PoisonError;

use fearless_simd::Level;
use pocketnerf_core::field::DerfField;
use pocketnerf_core::{AnyField, Error, Occupancy};

use super::nerf::{self, Gradients, NerfGradients};
use super::{Back, Context, FieldConfig, FieldKind, Layout, TrainableField, Training, Update};
use crate::pool::Pool;
use back::{DerfBack, Worker};
pub use config::DerfConfig;

/// The field in training. It learns as it is, in `f32`.
#[derive(Debug)]
struct TrainableDerf {
    config: DerfConfig,
    sites: Vec<[f32; 3]>,
    scale: f32,
    layout: Layout,
    /// One a head.
    networks: Vec<NerfGradients>,
    gradients: Gradients,
    /// Buffers of the way back, as many as there are threads.
    workers: Pool<Worker>,
}

impl From<DerfConfig> for FieldConfig {
    fn from(field: DerfConfig) -> Self {
        Self::Derf(field)
    }
}

impl FieldKind for DerfConfig {
    fn training(&self) -> Training {
        self.head.training()
    }

    fn build(&self, scale: f32) -> Box<dyn TrainableField> {
        let layout = self.layout();
        let networks = NerfGradients::new(&self.head, &self.head.layout());
        Box::new(TrainableDerf {
            config: self.clone(),
            sites: self.sites(),
            scale,
            networks: vec![networks; self.n_heads],
            gradients: Gradients::new(layout.len()),
            workers: Pool::default(),
            layout,
        })
    }

    fn layout(&self) -> Layout {
        self.layout()
    }

    fn coarse(&self) -> FieldConfig {
        self.head.coarse()
    }

    fn validate(&self) -> Result<(), Error> {
        self.check()
    }

    fn is_costly(&self) -> bool {
        true
    }

    fn within(&self, cells: &Occupancy<'_>) -> Option<FieldConfig> {
        self.sites.is_empty().then(|| FieldConfig::Derf(self.within(cells)))
    }

    fn section(&self) -> Option<Vec<u8>> {
        Some(self.section())
    }
}

impl TrainableDerf {
    fn field<'a>(&'a self, parameters: &'a [f32]) -> Result<DerfField<'a>, Error> {
        self.config.view(&self.sites, self.scale, parameters)
    }

    /// Parameters of a head.
    fn head_len(&self) -> usize {
        self.layout.len() / self.config.n_heads
    }
}

impl TrainableField for TrainableDerf {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn initialize(&self, seed: u64, parameters: &mut [f32]) {
        nerf::initialize(&self.config.head, &self.layout, seed, parameters);
    }

    fn view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        let field = AnyField::Derf(self.field(parameters)?);
        field.validate()?;
        Ok(field)
    }

    fn set(&mut self, _: Level, _: &[f32]) {
        self.gradients.sum.fill(0.0);
    }

    fn prepare(&mut self, parameters: &[f32], groups: usize) {
        let heads = parameters.chunks_exact(self.head_len());
        for (networks, own) in self.networks.iter_mut().zip(heads) {
            networks.update(own);
        }
        self.gradients.prepare(groups);
    }

    fn back<'a>(&'a self, group: usize, context: Context<'a>) -> Box<dyn Back + 'a> {
        let mut gradient =
            self.gradients.groups[group].lock().unwrap_or_else(PoisonError::into_inner);
        gradient.fill(0.0);
        Box::new(DerfBack::new(self, gradient, context))
    }

    #[cfg(test)]
    fn gradient(&self, _: Level, _: &[f32]) -> Vec<f32> {
        self.gradients.summed()
    }

    fn update(&mut self, update: Update<'_>) {
        self.gradients.follow(self.config.head.muon, &self.layout, update);
    }
}
