//! A multiresolution hash grid (Müller et al. 2022), a density network and a colour
//! network, trainable.

mod back;
mod config;
#[cfg(test)]
mod gradient_tests;
mod init;
mod networks;
mod positions;
mod scatter;
mod update;

use std::sync::{Mutex, PoisonError};

use fearless_simd::Level;
use pocketnerf_core::field::HashGridField;
use pocketnerf_core::{AnyField, Error};

pub use config::HashGridFieldConfig;

use super::{
    Back, Context, FieldConfig, FieldKind, Layout, Range, Rounded, TrainableField, Update,
};
use crate::aligned::Aligned;
use crate::pool::Pool;
use back::{GroupGradients, HashGridBack, Worker};
use networks::Networks;

/// The field in training. The forward pass reads rounded parameters.
#[derive(Debug)]
struct TrainableHashGrid {
    config: HashGridFieldConfig,
    log_density_bias: f32,
    layout: Layout,
    rounded: Rounded,
    /// Whether tables are rounded as coarsely as a model of few bytes is.
    coarse: bool,
    networks: Networks,
    /// Of each group of rays. A group has one thread at a time.
    groups: Vec<Mutex<GroupGradients>>,
    /// Sum of the networks' gradients.
    gradient: Vec<f32>,
    /// Gradient buffers of levels, as many as there are threads: a level's is full only
    /// between its scatter and its update, and stays in the cache.
    level_gradients: Pool<Aligned<f32>>,
    /// Buffers of the way back, as many as there are threads.
    workers: Pool<Worker>,
    /// Whether the forward pass reads the parameters themselves: rounding would hide the
    /// differences by which tests find gradients.
    exact: bool,
}

impl FieldKind for HashGridFieldConfig {
    fn build(&self, scale: f32) -> Box<dyn TrainableField> {
        let layout = self.layout();
        Box::new(TrainableHashGrid {
            config: self.clone(),
            // Density is learnt per unit length of the cube, whatever its size.
            log_density_bias: scale.ln(),
            rounded: Rounded::new(&layout),
            coarse: false,
            networks: Networks::new(self, &layout),
            groups: Vec::new(),
            gradient: vec![0.0; layout.len() - layout.networks_start()],
            level_gradients: Pool::default(),
            workers: Pool::default(),
            exact: false,
            layout,
        })
    }

    fn layout(&self) -> Layout {
        self.layout()
    }

    fn coarse(&self) -> FieldConfig {
        FieldConfig::HashGrid(self.coarse())
    }

    fn validate(&self) -> Result<(), Error> {
        self.grid.validate()
    }
}

impl TrainableField for TrainableHashGrid {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn initialize(&self, seed: u64, parameters: &mut [f32]) {
        init::initialize(&self.layout, seed, parameters);
    }

    fn view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        let tensor = |range: &Range| range.of(parameters);
        let field = self.config.view(&self.layout, self.log_density_bias, tensor)?;
        validated(AnyField::HashGrid(field))
    }

    fn training_view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        validated(AnyField::HashGrid(self.training_field(parameters)?))
    }

    fn set(&mut self, level: Level, parameters: &[f32]) {
        self.rounded.round(level, &self.layout, parameters);
        self.coarse = false;
        self.gradient.fill(0.0);
    }

    fn prepare(&mut self, parameters: &[f32], groups: usize) {
        self.networks.update(&parameters[self.layout.networks_start()..]);
        let new = || Mutex::new(GroupGradients::new(self.gradient.len()));
        self.groups.resize_with(groups, new);
    }

    fn back<'a>(&'a self, group: usize, context: Context<'a>) -> Box<dyn Back + 'a> {
        let mut gradients = self.groups[group].lock().unwrap_or_else(PoisonError::into_inner);
        gradients.clear();
        Box::new(HashGridBack::new(self, gradients, context))
    }

    #[cfg(test)]
    fn set_exact(&mut self) {
        self.exact = true;
    }

    #[cfg(test)]
    fn gradient(&self, level: Level) -> Vec<f32> {
        self.summed(level)
    }

    fn update(&mut self, update: Update<'_>) {
        self.update_parameters(update);
    }

    fn round_coarsely(&mut self, level: Level, lengths: &[f32], parameters: &[f32]) {
        let scales = self.rounded.scales.iter().zip(lengths);
        let scales: Vec<_> = scales.map(|(scale, length)| scale.with_step_of(*length)).collect();
        self.coarse = true;
        self.rounded.round_tables(level, &self.layout, &scales, parameters);
    }

    fn scales(&self) -> Vec<u8> {
        self.rounded.scales(self.coarse)
    }

    fn restore_scales(&mut self, level: Level, scales: &[u8], parameters: &[f32]) -> bool {
        let coarse = self.rounded.restore_scales(level, &self.layout, scales, parameters);
        self.coarse = coarse.unwrap_or(self.coarse);
        coarse.is_some()
    }
}

impl TrainableHashGrid {
    /// The field of rounded parameters.
    fn training_field<'a>(&'a self, parameters: &'a [f32]) -> Result<HashGridField<'a>, Error> {
        self.config.view(&self.layout, self.log_density_bias, |range| {
            if self.exact { range.of(parameters) } else { self.rounded.tensor(range) }
        })
    }
}

fn validated(field: AnyField<'_>) -> Result<AnyField<'_>, Error> {
    field.validate()?;
    Ok(field)
}
