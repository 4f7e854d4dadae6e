//! A field's place on a GPU.

use pocketnerf_core::{ColorSpace, Display, Model, Occupancy, Sampling, Space};
use pocketnerf_gpu::training::Learner;
use pocketnerf_gpu::{Error, Gpu};

use super::Cpu;

/// Where a field is: its space, how rays are sampled, and which cells they cross.
pub(crate) type Scene<'s> = (Space, Sampling, Occupancy<'s>);

/// What takes the steps of a field on a GPU.
pub(super) fn learner(
    gpu: &Gpu,
    cpu: &Cpu,
    (space, sampling, occupancy): Scene<'_>,
    cameras: &[[f32; 3]],
    samples: u32,
) -> Result<Learner, Error> {
    if cpu.state.groups.len() > 1 {
        return Err(Error::Untrainable("the poses and the exposure of photographs"));
    }
    let display = Display {
        background: [0.0; 3],
        color_space: ColorSpace::Srgb,
        tolerance: Display::TOLERANCE,
    };
    let model = Model {
        field: cpu.field.training_view(&cpu.state.field().parameters)?,
        space,
        occupancy: Some(occupancy),
        sampling,
        hierarchical: None,
        display,
    };
    Learner::new(gpu, &model, cameras, samples)
}
