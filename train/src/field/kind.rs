//! What is known of a kind of field before there are parameters.

use std::fmt::Debug;

use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::{Error, Occupancy};

use super::{FieldConfig, HierarchicalTraining, Layout, TrainableField};

/// What is known of a kind of field before there are parameters.
pub trait FieldKind: Debug {
    /// A field of this shape, whose densities are per `1 / scale` scene units.
    fn build(&self, scale: f32) -> Box<dyn TrainableField>;

    /// Where each tensor lies among the parameters.
    fn layout(&self) -> Layout;

    /// Numbers that are learnt in the end, where the shape alone says how much finer it becomes.
    fn n_parameters(&self) -> usize {
        self.layout().len()
    }

    /// How it is trained, where nothing else is asked for.
    fn training(&self) -> Training {
        Training::USUAL
    }

    /// A small field that learns the outline of the same scene in a second.
    fn coarse(&self) -> FieldConfig;

    /// Checks that there can be such a field.
    ///
    /// # Errors
    /// What core's validation reports of an encoding.
    fn validate(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Levels through which positions have a gradient, the coarsest first; 0: they have none.
    fn n_levels(&self) -> usize {
        0
    }

    /// Whether models of a size that is asked for can be made of it.
    fn can_be_sized(&self) -> bool {
        false
    }

    /// Whether a sample takes a thousand times as long as one of a hash grid.
    fn is_costly(&self) -> bool {
        false
    }

    /// How it is trained by hierarchical sampling, where it is.
    fn hierarchical_training(&self) -> Option<HierarchicalTraining> {
        None
    }

    /// Numbers of samples for rendering by hierarchical sampling, where its models have them.
    fn hierarchical_sampling(&self) -> Option<Hierarchical> {
        None
    }

    /// Whether it keeps nothing of cells that hold nothing.
    fn is_sparse(&self) -> bool {
        false
    }

    /// The same field where these cells alone may hold anything; `None` where it is not sparse,
    /// and where that is known already.
    fn within(&self, _: &Occupancy<'_>) -> Option<FieldConfig> {
        None
    }

    /// Whether the field is to become finer, when so much of a run is over.
    fn is_due_to_grow(&self, _progress: f32) -> bool {
        false
    }

    /// The finer field that is due, where these cells alone hold anything, with the values of
    /// this one: parameters and second moments.
    fn grown(
        &self,
        _progress: f32,
        _cells: &Occupancy<'_>,
        [_parameters, _square]: [&[f32]; 2],
    ) -> Option<Grown> {
        None
    }

    /// What to say of a field that could not become what was asked for.
    fn doubt(&self) -> Option<String> {
        None
    }

    /// What a checkpoint holds beside the model, where the kind has such a section.
    fn section(&self) -> Option<Vec<u8>> {
        None
    }
}

/// How a kind of field is trained, where nothing else is asked for: what
/// [`TrainConfig`](crate::trainer::TrainConfig) begins with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Training {
    /// Cells of the occupancy along an axis.
    pub occupancy_resolution: u32,
    /// Samples along the longest side of the box.
    pub samples_per_side: f32,
    /// Rays a step; `None`: as many as give the usual number of samples.
    pub batch_rays: Option<usize>,
    /// Learning rate of table entries at its highest.
    pub grid_rate: f32,
    /// Decay of table entries, summed over the steps of a run.
    pub grid_decay: f32,
    /// How much table entries are drawn to the mean of their neighbours, summed over the steps of
    /// a run; 0 where neighbours in a table are not neighbours in the scene.
    pub grid_smoothing: f32,
    /// Learning rate of network weights at its highest.
    pub network_rate: f32,
    /// Share of samples that are passed back, at the start and at the end.
    pub kept: [f32; 2],
    /// Steps are so many times longer at the start.
    pub first_step_scale: f32,
    /// Steps of which fewer lose a decibel or more, where that is more than it takes to take shape.
    pub least_steps: u32,
}

impl Training {
    /// Hash grids'.
    pub const USUAL: Self = Self {
        occupancy_resolution: 128,
        samples_per_side: 350.0,
        batch_rays: None,
        grid_rate: 2e-2,
        grid_decay: 350.0,
        grid_smoothing: 0.0,
        network_rate: 2e-2,
        kept: [0.1, 0.5],
        first_step_scale: 2.5,
        least_steps: 0,
    };
}

impl HierarchicalTraining {
    /// 64 + 128 samples, no noise, no crop.
    pub const PLAIN: Self = Self {
        sampling: Hierarchical { reach: Reach::Clipped, ..Hierarchical::PAPER },
        noise: 0.0,
        crop_steps: 0,
    };
}

/// A field that became finer.
#[derive(Debug)]
pub struct Grown {
    /// Its shape.
    pub field: FieldConfig,
    /// Its parameters, which say the same.
    pub parameters: Vec<f32>,
    /// Their second moments.
    pub square: Vec<f32>,
}

/// Why a field cannot be trained on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unusable {
    /// The model is not one that training makes.
    Model(&'static str),
    /// What a checkpoint adds is missing.
    NoSection,
    /// What a checkpoint adds is damaged.
    Section,
}
