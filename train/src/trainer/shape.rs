//! Fields of another shape: before the first step, and finer ones later.

use pocketnerf_core::Error;

use super::backend::{Backend, Cpu};
use super::parameters::{ParameterGroup, State};
use super::photographs::learnt_gains;
use super::{TrainConfig, Trainer, backend};
use crate::field::FieldConfig;
use crate::picture::Device;

impl Trainer {
    /// Begins anew with a field of another shape, and samples closer together or less close.
    ///
    /// # Errors
    /// When these do not make a valid field.
    pub fn reshape(&mut self, field: FieldConfig, samples_per_side: f32) -> Result<(), Error> {
        let config = TrainConfig { field, samples_per_side, ..self.config.clone() };
        let sampling = config.sampling(&self.space)?;
        let (poses, gains) = (self.poses.as_ref(), learnt_gains(&self.source, &config));
        let backend = backend(&config, &self.space, poses, gains, self.backend.simd())?;
        (self.config, self.sampling, self.backend) = (config, sampling, Box::new(backend));
        self.begin(0);
        if !matches!(self.device, Device::Cpu) {
            self.move_to_device();
        }
        Ok(())
    }

    /// The field becomes finer, where that is due.
    pub(super) fn grow(&mut self, progress: f32) -> Result<(), Error> {
        let kind = self.config.field.kind();
        if !kind.is_due_to_grow(progress) {
            return Ok(());
        }
        let state = self.backend.download().clone();
        let values = [&state.field().parameters[..], &state.field().square[..]];
        let Some(grown) = kind.grown(progress, &self.grid.grown(), values) else { return Ok(()) };
        let config = TrainConfig { field: grown.field, ..self.config.clone() };
        let field = config.field.kind().build(self.space.unit_map().scale);
        let mut group = ParameterGroup::of_field(field.layout(), config.adam());
        group.parameters.copy_from_slice(&grown.parameters);
        group.square.copy_from_slice(&grown.square);
        let mut groups = state.groups;
        // Networks stay as they are.
        group.mean.copy_from_slice(&groups[0].mean);
        groups[0] = group;
        let state = State { groups, averaged: 0, scales: Vec::new() };
        let mut backend = Cpu::new(field, state.clone(), self.backend.simd())?;
        backend.upload(state);
        (self.config, self.backend, self.best) = (config, Box::new(backend), None);
        Ok(())
    }
}
