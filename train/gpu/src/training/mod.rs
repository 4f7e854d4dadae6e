//! Trains hash grids on GPUs: the steps of `pocketnerf-train`, kernel by kernel.
//!
//! A [`Learner`] holds the tables, their gradients and second moments in the GPU's memory. The
//! caller draws the rays of a step, hands over the networks, which are small, and takes their
//! gradient back: [`Learner::set_networks`], then [`Learner::step`]. Tables follow their gradient
//! on the GPU.
//!
//! A step is about forty dispatches, in the order of the fields of `Pipelines`:
//! * `trace`: rays forwards, and their samples noted;
//! * `shade`, `dense_rays`, `loss`: colours, errors, and back through the colour network;
//! * `drop`, `scan`, `gather`: gradients of samples, of which small ones are dropped by chance;
//! * `encode_again`, `dense_samples`: back through the density network;
//! * `outer_*`, `reduce`: the gradient of the networks;
//! * `sum_units`, `find_units`, `scatter`: the gradient of entries, in whole numbers, whose sum does not depend
//!   on the order;
//! * `adam`, `hold_all`, `round_all`, `accumulate`: new entries, and what is rounded of them.
//!
//! The same rays give the same bytes on one GPU, however its threads run.

mod fixed;
mod kernel;
mod learner;
mod memory;
mod networks;
mod pipelines;
mod plan;
mod sequence;
mod step;
mod tables;

pub use learner::Learner;
pub use plan::source;
pub use step::{Pixel, PixelNumbers, RayResult, Settings, StepResult, TableRates, Tables};
