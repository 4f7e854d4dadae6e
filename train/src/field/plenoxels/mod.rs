//! Plenoxels (Fridovich-Keil et al. 2022), trainable: a sparse grid of densities and spherical
//! harmonics, which becomes finer while it learns, and no network.

mod back;
mod bricks;
mod config;
#[cfg(test)]
mod tests;
mod update;

use std::sync::{Arc, Mutex, PoisonError};

use fearless_simd::Level;
use pocketnerf_core::{AnyField, Error, Occupancy};

pub use config::PlenoxelsConfig;

use super::{
    Back, Context, FieldConfig, FieldKind, Grown, HashGridFieldConfig, Layout, Rounded,
    TrainableField, Training, Update,
};
use crate::aligned::Aligned;
use crate::pool::Pool;
use back::{GroupGradients, PlenoxelsBack};
use bricks::Bricks;
use config::{carried_over, validated};

/// The field in training. The forward pass reads rounded values.
#[derive(Debug)]
struct TrainablePlenoxels {
    config: PlenoxelsConfig,
    bricks: Arc<Bricks>,
    log_density_bias: f32,
    layout: Layout,
    rounded: Rounded,
    /// Of each group of rays. A group has one thread at a time.
    groups: Vec<Mutex<GroupGradients>>,
    /// Gradient buffers of slabs, as many as there are threads; all 0 between two steps.
    slab_gradients: Pool<Aligned<f32>>,
    /// Whether the forward pass reads the parameters themselves.
    exact: bool,
}

impl From<PlenoxelsConfig> for FieldConfig {
    fn from(field: PlenoxelsConfig) -> Self {
        Self::Plenoxels(field)
    }
}

impl FieldKind for PlenoxelsConfig {
    fn training(&self) -> Training {
        Training {
            samples_per_side: 1.5 * self.last_resolution as f32,
            grid_rate: 5e-2,
            grid_decay: 0.0,
            kept: [0.3, 0.5],
            first_step_scale: 1.5,
            ..Training::USUAL
        }
    }

    fn build(&self, scale: f32) -> Box<dyn TrainableField> {
        let bricks = self.bricks();
        let config = Self { bricks: Some(Arc::clone(&bricks)), ..self.clone() };
        let layout = config.layout();
        Box::new(TrainablePlenoxels {
            // Density is learnt per unit length of the cube, whatever its size.
            log_density_bias: scale.ln(),
            rounded: Rounded::new(&layout),
            groups: Vec::new(),
            slab_gradients: Pool::default(),
            exact: false,
            config,
            bricks,
            layout,
        })
    }

    fn layout(&self) -> Layout {
        self.layout()
    }

    fn coarse(&self) -> FieldConfig {
        FieldConfig::HashGrid(HashGridFieldConfig::default().coarse())
    }

    fn validate(&self) -> Result<(), Error> {
        self.check()
    }

    fn is_sparse(&self) -> bool {
        true
    }

    fn within(&self, cells: &Occupancy<'_>) -> Option<FieldConfig> {
        self.bricks.is_none().then(|| FieldConfig::Plenoxels(self.within(cells)))
    }

    fn is_due_to_grow(&self, progress: f32) -> bool {
        self.due(progress).is_some()
    }

    fn grown(
        &self,
        progress: f32,
        cells: &Occupancy<'_>,
        [parameters, square]: [&[f32]; 2],
    ) -> Option<Grown> {
        let new = self.due(progress)?.within(cells);
        let carried = |values: &[f32]| carried_over((self, values), &new);
        let (parameters, square) = (carried(parameters), carried(square));
        Some(Grown { field: FieldConfig::Plenoxels(new), parameters, square })
    }

    fn doubt(&self) -> Option<String> {
        let Self { last_resolution, asked, .. } = self;
        (last_resolution < asked).then(|| {
            format!(
                "the scene fills more than the 65,535 bricks of 4 x 4 x 4 voxels that a file \
                 numbers: {last_resolution} voxels along its longest side, expected {asked}; ask \
                 for fewer, or give a smaller box"
            )
        })
    }

    fn section(&self) -> Option<Vec<u8>> {
        Some(self.section())
    }
}

impl TrainableField for TrainablePlenoxels {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Thin fog of grey.
    fn initialize(&self, _: u64, parameters: &mut [f32]) {
        parameters.fill(0.0);
    }

    fn view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        let values = self.layout.tables()[0].of(parameters)?;
        validated(self.config.view(&self.bricks, self.log_density_bias, values)?)
    }

    fn training_view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        if self.exact {
            return self.view(parameters);
        }
        let values = self.rounded.tensor(&self.layout.tables()[0])?;
        validated(self.config.view(&self.bricks, self.log_density_bias, values)?)
    }

    fn set(&mut self, level: Level, parameters: &[f32]) {
        self.rounded.round(level, &self.layout, parameters);
    }

    fn prepare(&mut self, _: &[f32], groups: usize) {
        self.groups.resize_with(groups, Mutex::default);
    }

    fn back<'a>(&'a self, group: usize, context: Context<'a>) -> Box<dyn Back + 'a> {
        let mut gradients = self.groups[group].lock().unwrap_or_else(PoisonError::into_inner);
        gradients.clear();
        Box::new(PlenoxelsBack::new(self, gradients, context))
    }

    #[cfg(test)]
    fn set_exact(&mut self) {
        self.exact = true;
    }

    #[cfg(test)]
    fn gradient(&self, level: Level, _: &[f32]) -> Vec<f32> {
        self.summed(level)
    }

    fn update(&mut self, update: Update<'_>) {
        self.update_parameters(update);
    }

    fn scales(&self) -> Vec<u8> {
        self.rounded.scales(false)
    }

    fn restore_scales(&mut self, level: Level, scales: &[u8], parameters: &[f32]) -> bool {
        self.rounded.restore_scales(level, &self.layout, scales, parameters) == Some(false)
    }
}
