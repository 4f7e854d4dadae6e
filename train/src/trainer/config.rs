//! Settings of a training run.

use pocketnerf_core::space::{Contracted, Ndc};
use pocketnerf_core::{Error, Sampling, Space};

use super::Adam;
use super::run::guard;
use super::step::group::MIN_TRANSMITTANCE;
use crate::field::{FieldConfig, HierarchicalTraining};

/// Everything that decides what a run learns, apart from its data and length.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainConfig {
    /// Shape of the field.
    pub field: FieldConfig,
    /// Where random numbers begin.
    pub seed: u64,
    /// The box of the scene, smallest and largest corner; `None`: the dataset's, or, where
    /// it has none, found from the cameras, the silhouettes and a small field. A trainer's
    /// own is never `None`.
    pub aabb: Option<[[f32; 3]; 2]>,
    /// `Some`: a forward-facing capture, learnt in normalised device coordinates; there
    /// is no box in scene units then. [`ndc_of`](super::ndc_of) finds them.
    pub ndc: Option<Ndc>,
    /// `Some`: a scene without an end, learnt in contracted space; there is no box in scene
    /// units then. [`contracted_of`](super::contracted_of) finds it, and
    /// [`TrainConfig::contracted`] sets it with as many samples as it takes.
    pub contracted: Option<Contracted>,
    /// Nothing is seen nearer to a camera than this, local units.
    pub near: f32,
    /// Nothing is seen farther than this; `None`: everything in the box.
    pub far: Option<f32>,
    /// Cells of the occupancy along an axis.
    pub occupancy_resolution: u32,
    /// Samples along the longest side of the box, of normalised device coordinates, or of all of
    /// contracted space, which is twice as wide as its cube.
    pub samples_per_side: f32,
    /// Rays a step; `None`: as many as give `samples_per_step`.
    pub batch_rays: Option<usize>,
    /// Samples a step aims at.
    pub samples_per_step: usize,
    /// Learning rate of grid entries at its highest.
    pub grid_rate: f32,
    /// Decay of grid entries, see [`Adam::decay`](super::Adam::decay),
    /// summed over the steps of a run: what some training views ask for and others
    /// do not is forgotten.
    pub grid_decay: f32,
    /// Learning rate of network weights at its highest.
    pub network_rate: f32,
    /// What remains of the learning rates at the end.
    pub final_rate: f32,
    /// Share of samples that the roulette passes back, at the start and at the
    /// end; 1: all.
    pub kept: [f32; 2],
    /// Steps are so many times longer at the start.
    pub first_step_scale: f32,
    /// Colour on which models of images without alpha are shown.
    pub opaque_backdrop: [f32; 3],
    /// `Some`: learn against this background, not against what random ones give on average.
    pub backdrop: Option<[f32; 3]>,
    /// How much surfaces are held to be smooth: the weight of a bend beside the error of a ray's
    /// colour. 0: they may be rough. Not for hierarchical sampling. For places there is
    /// [`SMOOTH_PLACES`](Self::SMOOTH_PLACES).
    pub smooth_surfaces: f32,
    /// Whether thin fog is removed while the field learns, unless training views become worse: from
    /// 40 to 80 % of a run, cells that hold little become empty. Not for hierarchical sampling.
    pub clear_fog: bool,
    /// Whether the poses of the photographs are corrected while the field learns: hash grids whose
    /// colours are those of rays.
    pub refine_poses: bool,
}

impl TrainConfig {
    /// How the field is trained by hierarchical sampling, where it is.
    #[must_use]
    pub fn hierarchical_training(&self) -> Option<HierarchicalTraining> {
        self.field.kind().hierarchical_training()
    }

    /// Steps after which the field has taken shape. Before that it is fog: calibrating its model
    /// would take longer than training it, and find nothing.
    #[must_use]
    pub fn settled(&self) -> u32 {
        // A costly field takes few steps of many rays each; by hierarchical sampling, though,
        // it learns empty space slowly.
        match (self.field.kind().is_costly(), self.hierarchical_training()) {
            (true, None) => 100,
            _ => guard::PATIENCE,
        }
    }

    /// Steps of which fewer are too few: details are still missing, though the field may have taken
    /// shape.
    #[must_use]
    pub fn least_steps(&self) -> u32 {
        self.settled().max(self.field.kind().training().least_steps)
    }

    /// Distance of samples, and limits of rays.
    pub(crate) fn sampling(&self, space: &Space) -> Result<Sampling, Error> {
        space.validate()?;
        let scale = space.unit_map().scale;
        let sampling = Sampling {
            step: 1.0 / (scale * self.samples_per_side),
            near: self.near,
            far: self.far.unwrap_or(self.near + 64.0 / scale),
            min_transmittance: MIN_TRANSMITTANCE,
        };
        sampling.validate()?;
        Ok(sampling)
    }

    /// The constants of Adam.
    pub(crate) fn adam(&self) -> Adam {
        let Some(_) = self.hierarchical_training() else { return Adam::default() };
        // The original's. Its gradient is that of the mean squared error, ours that of half
        // the sum.
        let mean = 1.5 * self.batch_rays.unwrap_or(1) as f32;
        Adam { beta1: 0.9, beta2: 0.999, epsilon: 1e-7 * mean, decay: 0.0 }
    }
}
