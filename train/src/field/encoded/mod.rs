//! Tables that encode positions, a density network and a colour network, trainable: what the
//! kinds of field have in common that are an [`Encoding`] each.

mod back;
mod config;
mod encoding;
#[cfg(test)]
mod gradient_tests;
mod init;
mod networks;
mod update;

use std::sync::{Mutex, PoisonError};

use fearless_simd::Level;
use pocketnerf_core::field::Decoder;
use pocketnerf_core::{AnyField, Error, Occupancy, TensorView};

pub use config::EncodedFieldConfig;
pub use encoding::Encoding;

use super::{
    Back, Context, FieldConfig, FieldKind, Grown, Layout, Range, Rounded, TrainableField, Training,
    Update,
};
use crate::aligned::Aligned;
use crate::pool::Pool;
use back::{EncodedBack, GroupGradients, Worker};
use networks::Networks;

/// The field in training. The forward pass reads rounded parameters.
#[derive(Debug)]
struct TrainableEncoded<E> {
    config: EncodedFieldConfig<E>,
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
    /// Gradient buffers of tables, as many as there are threads: a task's is full only
    /// between its scatter and its update, and stays in the cache.
    table_gradients: Pool<Aligned<f32>>,
    /// Buffers of the way back, as many as there are threads.
    workers: Pool<Worker>,
    /// Whether the forward pass reads the parameters themselves: rounding would hide the
    /// differences by which tests find gradients.
    exact: bool,
}

impl<E: Encoding> From<EncodedFieldConfig<E>> for FieldConfig {
    fn from(field: EncodedFieldConfig<E>) -> Self {
        E::config(field)
    }
}

impl<E: Encoding> FieldKind for EncodedFieldConfig<E> {
    fn build(&self, scale: f32) -> Box<dyn TrainableField> {
        let layout = self.layout();
        Box::new(TrainableEncoded {
            config: self.clone(),
            // Density is learnt per unit length of the cube, whatever its size.
            log_density_bias: scale.ln(),
            rounded: Rounded::new(&layout),
            coarse: false,
            networks: Networks::new(self, &layout),
            groups: Vec::new(),
            gradient: vec![0.0; layout.len() - layout.networks_start()],
            table_gradients: Pool::default(),
            workers: Pool::default(),
            exact: false,
            layout,
        })
    }

    fn layout(&self) -> Layout {
        self.layout()
    }

    fn n_parameters(&self) -> usize {
        let grid = self.grid.due(1.0).unwrap_or_else(|| self.grid.clone());
        Self { grid, ..self.clone() }.layout().len()
    }

    fn training(&self) -> Training {
        self.grid.training()
    }

    fn n_levels(&self) -> usize {
        self.grid.n_levels()
    }

    fn can_be_sized(&self) -> bool {
        true
    }

    fn coarse(&self) -> FieldConfig {
        FieldConfig::HashGrid(self.coarse())
    }

    fn validate(&self) -> Result<(), Error> {
        self.grid.validate()
    }

    fn is_due_to_grow(&self, progress: f32) -> bool {
        self.grid.due(progress).is_some()
    }

    fn grown(&self, progress: f32, _: &Occupancy<'_>, values: [&[f32]; 2]) -> Option<Grown> {
        let field = Self { grid: self.grid.due(progress)?, ..self.clone() };
        let layout = self.layout();
        let [parameters, square] = values.map(|values| {
            let tables: Vec<_> = layout.tables().iter().map(|t| &values[t.indices()]).collect();
            let mut to = self.grid.carried_over(&field.grid, &tables);
            to.extend(&values[layout.networks_start()..]);
            to
        });
        Some(Grown { field: E::config(field), parameters, square })
    }

    fn section(&self) -> Option<Vec<u8>> {
        self.grid.section()
    }
}

impl<E: Encoding> TrainableField for TrainableEncoded<E> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn initialize(&self, seed: u64, parameters: &mut [f32]) {
        init::initialize(&self.config.grid, &self.layout, seed, parameters);
    }

    fn view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        let tensor = |range: &Range| range.of(parameters);
        let (grid, decoder) = self.config.view(&self.layout, self.log_density_bias, tensor)?;
        validated(E::field(grid, decoder))
    }

    fn training_view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        let (grid, decoder) = self.training_field(parameters)?;
        validated(E::field(grid, decoder))
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
        Box::new(EncodedBack::new(self, gradients, context))
    }

    #[cfg(test)]
    fn set_exact(&mut self) {
        self.exact = true;
    }

    #[cfg(test)]
    fn gradient(&self, level: Level, parameters: &[f32]) -> Vec<f32> {
        self.summed(level, parameters)
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

impl<E: Encoding> TrainableEncoded<E> {
    /// The encoding and the networks of rounded parameters.
    fn training_field<'a>(
        &'a self,
        parameters: &'a [f32],
    ) -> Result<(E::View<'a>, Decoder<'a>), Error> {
        let tensor = |range: &Range| self.read(parameters, range);
        self.config.view(&self.layout, self.log_density_bias, tensor)
    }

    /// A tensor as the forward pass reads it.
    fn read<'a>(&'a self, parameters: &'a [f32], range: &Range) -> Result<TensorView<'a>, Error> {
        if self.exact { range.of(parameters) } else { self.rounded.tensor(range) }
    }
}

fn validated(field: AnyField<'_>) -> Result<AnyField<'_>, Error> {
    field.validate()?;
    Ok(field)
}
