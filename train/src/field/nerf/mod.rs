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
mod weights;

use std::sync::{Mutex, PoisonError};

use fearless_simd::{Level, dispatch};
use pocketnerf_core::field::NerfField;
use pocketnerf_core::march::Hierarchical;
use pocketnerf_core::{AnyField, Error};

use backward::NerfGradients;
pub use config::{FourierConfig, NerfConfig, WavesConfig};
pub use layout::NerfLayer;
pub(super) use report::report;
pub use report::{EncodingReport, NetworkReport, NetworksReport, WavesReport};

use super::rounding::Unrounded;
use super::{
    Back, Context, FieldConfig, FieldKind, HashGridFieldConfig, HierarchicalTraining, Layout,
    TrainableField, Update, sum_groups,
};
use crate::pool::Pool;
use crate::stopwatch::{Laps, Stage};
use crate::trainer::{Slices, muon};
use back::{NerfBack, Worker};

/// The field in training. It learns as it is, in `f32`.
#[derive(Debug)]
struct TrainableNerf {
    scale: f32,
    layout: Layout,
    networks: NerfGradients,
    /// Gradients of each group of rays. A group has one thread at a time.
    groups: Vec<Mutex<Vec<f32>>>,
    /// Their sum.
    gradient: Vec<f32>,
    /// Buffers of the way back, as many as there are threads.
    workers: Pool<Worker>,
}

impl FieldKind for NerfConfig {
    fn build(&self, scale: f32) -> Box<dyn TrainableField> {
        let layout = self.layout();
        Box::new(TrainableNerf {
            scale,
            networks: NerfGradients::new(self, &layout),
            groups: Vec::new(),
            gradient: vec![0.0; layout.len()],
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
        init::initialize(self.networks.config(), &self.layout, seed, parameters);
    }

    fn view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        let field = AnyField::Nerf(self.field(parameters)?);
        field.validate()?;
        Ok(field)
    }

    fn set(&mut self, _: Level, _: &[f32]) {
        self.gradient.fill(0.0);
    }

    fn prepare(&mut self, parameters: &[f32], groups: usize) {
        self.networks.update(parameters);
        self.groups.resize_with(groups, || Mutex::new(vec![0.0; self.layout.len()]));
    }

    fn back<'a>(&'a self, group: usize, context: Context<'a>) -> Box<dyn Back + 'a> {
        let mut gradient = self.groups[group].lock().unwrap_or_else(PoisonError::into_inner);
        gradient.fill(0.0);
        Box::new(NerfBack::new(self, gradient, context))
    }

    #[cfg(test)]
    fn gradient(&self, _: Level) -> Vec<f32> {
        let mut sum = vec![0.0; self.layout.len()];
        for group in &self.groups {
            sum.iter_mut().zip(&*group.lock().unwrap()).for_each(|(sum, g)| *sum += g);
        }
        sum
    }

    fn update(&mut self, update: Update<'_>) {
        let Update { level, parameters, mean, square, step, adam, rate, stopwatch, .. } = update;
        let Self { layout, groups, gradient, networks, .. } = self;
        let mut laps = Laps::begin(stopwatch);
        let groups: Vec<&[f32]> = groups
            .iter_mut()
            .map(|group| &group.get_mut().unwrap_or_else(PoisonError::into_inner)[..])
            .collect();
        sum_groups(gradient, &groups);
        laps.end(Stage::Reduce, 1);
        let rounded = &mut vec![(); parameters.len()][..];
        let slices = Slices { parameters, gradient, mean, square, rounded };
        let corrected = adam.corrected(rate, step);
        if networks.config().muon && step <= muon::STEPS {
            muon::update_all(level, rate, layout, (&adam, corrected), Unrounded, slices);
        } else {
            dispatch!(level, simd => adam.update(simd, corrected, Unrounded, slices));
        }
        laps.end(Stage::Adam, 0);
    }
}
