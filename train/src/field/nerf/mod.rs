//! A vanilla NeRF (Mildenhall et al. 2020), trainable.
//!
//! Forwards it is core's kernels, layer by layer, with every layer's output kept
//! (`tape`); backwards, two products a layer (`backward`).

mod back;
mod backward;
mod checkpoint;
mod config;
mod init;
mod layout;
mod report;
mod tape;
#[cfg(test)]
mod tests;
mod update;
mod weights;

use std::sync::PoisonError;

use fearless_simd::Level;
use pocketnerf_core::field::NerfField;
use pocketnerf_core::march::Hierarchical;
use pocketnerf_core::{AnyField, Error};

pub(super) use back::d_raw;
pub(super) use backward::{NerfGradients, NerfWork};
pub use config::{FourierConfig, NerfConfig, WavesConfig};
pub(super) use init::initialize;
pub use layout::NerfLayer;
pub(super) use report::report;
pub use report::{EncodingReport, NetworkReport, NetworksReport, WavesReport};
pub(super) use tape::NerfTape;
pub(super) use update::Gradients;

use super::{
    Back, Context, FieldConfig, FieldKind, HashGridFieldConfig, HierarchicalTraining, Layout,
    TrainableField, Training, Update,
};
use crate::pool::Pool;
use back::{NerfBack, Worker};

/// The field in training. It learns as it is, in `f32`.
#[derive(Debug)]
struct TrainableNerf {
    scale: f32,
    layout: Layout,
    networks: NerfGradients,
    gradients: Gradients,
    /// Buffers of the way back, as many as there are threads.
    workers: Pool<Worker>,
}

impl From<NerfConfig> for FieldConfig {
    fn from(field: NerfConfig) -> Self {
        Self::Nerf(field)
    }
}

impl FieldKind for NerfConfig {
    fn training(&self) -> Training {
        let [samples_per_side, network_rate] = match self.hierarchical {
            None => [128.0, 4e-3],
            Some(_) => [256.0, 5e-4],
        };
        Training {
            occupancy_resolution: 64,
            samples_per_side,
            batch_rays: Some(4096),
            network_rate,
            kept: [0.5; 2],
            first_step_scale: 1.0,
            ..Training::USUAL
        }
    }

    fn build(&self, scale: f32) -> Box<dyn TrainableField> {
        let layout = self.layout();
        Box::new(TrainableNerf {
            scale,
            networks: NerfGradients::new(self, &layout),
            gradients: Gradients::new(layout.len()),
            workers: Pool::default(),
            layout,
        })
    }

    fn layout(&self) -> Layout {
        self.layout()
    }

    fn coarse(&self) -> FieldConfig {
        let sh_degree = if self.directions.is_some() { 4 } else { 1 };
        FieldKind::coarse(&HashGridFieldConfig { sh_degree, ..HashGridFieldConfig::default() })
    }

    fn is_costly(&self) -> bool {
        true
    }

    fn hierarchical_training(&self) -> Option<HierarchicalTraining> {
        self.hierarchical
    }

    fn hierarchical_sampling(&self) -> Option<Hierarchical> {
        Some(self.hierarchical.unwrap_or(HierarchicalTraining::PLAIN).sampling)
    }

    fn section(&self) -> Option<Vec<u8>> {
        Some(self.section())
    }
}

impl TrainableNerf {
    fn field<'a>(&self, parameters: &'a [f32]) -> Result<NerfField<'a>, Error> {
        let config = self.networks.config();
        config.view(&self.layout, self.scale, |range| range.of(parameters))
    }
}

impl TrainableField for TrainableNerf {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn initialize(&self, seed: u64, parameters: &mut [f32]) {
        initialize(self.networks.config(), &self.layout, seed, parameters);
    }

    fn view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        let field = AnyField::Nerf(self.field(parameters)?);
        field.validate()?;
        Ok(field)
    }

    fn set(&mut self, _: Level, _: &[f32]) {
        self.gradients.sum.fill(0.0);
    }

    fn prepare(&mut self, parameters: &[f32], groups: usize) {
        self.networks.update(parameters);
        self.gradients.prepare(groups);
    }

    fn back<'a>(&'a self, group: usize, context: Context<'a>) -> Box<dyn Back + 'a> {
        let mut gradient =
            self.gradients.groups[group].lock().unwrap_or_else(PoisonError::into_inner);
        gradient.fill(0.0);
        Box::new(NerfBack::new(self, gradient, context))
    }

    #[cfg(test)]
    fn gradient(&self, _: Level, _: &[f32]) -> Vec<f32> {
        self.gradients.summed()
    }

    fn update(&mut self, update: Update<'_>) {
        let by_muon = self.networks.config().muon;
        self.gradients.follow(by_muon, &self.layout, update);
    }
}
