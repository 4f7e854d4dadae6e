//! Trains hash grids on GPUs: the steps of `pocketnerf-train`, kernel by kernel.
//!
//! A [`Learner`] holds all that is learnt in the GPU's memory, with its gradients and moments. The
//! caller draws the rays of a step: [`Learner::begin`]. All else happens on the GPU, which may have
//! several steps before it: [`Learner::result`] waits for what became of one.
//!
//! A step is about forty dispatches, in the order of the fields of `Pipelines`:
//! * `trace`: rays forwards, and their samples noted;
//! * `shade`, `dense_rays`, `loss`: colours, errors, and back through the colour network;
//! * `drop`, `scan`, `gather`: gradients of samples, of which small ones are dropped by chance;
//! * `encode_again`, `dense_samples`: back through the density network;
//! * `outer_*`, `reduce`: the gradient of the networks;
//! * `follow`, `lay_out`: new networks, and where other kernels read them;
//! * `sum_units`, `find_units`, `scatter`: the gradient of entries, in whole numbers, whose sum does not depend
//!   on the order;
//! * `adam`, `hold_all`, `round_all`, `accumulate`: new entries, and what is rounded of them.
//!
//! The same rays give the same bytes on one GPU, however its threads run.

mod fixed;
mod following;
mod kernel;
mod learner;
mod memory;
mod networks;
mod pipelines;
mod plan;
mod sequence;
mod step;
mod tables;
mod under_way;

pub use learner::Learner;
pub use plan::source;
pub use step::{
    Learnt, NetworkRates, Pixel, PixelNumbers, RayResult, Settings, StepResult, TableRates,
};
pub use under_way::UnderWay;
