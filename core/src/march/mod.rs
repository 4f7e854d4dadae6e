//! The one ray pipeline: where along a ray the field is evaluated, and what its samples
//! add up to.
//!
//! Rays enter the space sixteen at a time ([`RayPacket`]) and go on one by one
//! ([`RayState`]). [`Marcher`] finds their samples in occupied cells;
//! [`hierarchical`] places them as the NeRF paper does. Samples of many rays share a
//! [`SampleBatch`], which the field evaluates at once, and each ray composites its own
//! ([`composite`]).

pub mod composite;
mod evaluate;
mod gather;
pub mod hierarchical;
mod marcher;
mod pipeline;
mod ray_packet;
mod ray_slots;
mod ray_state;
mod register;
mod sample_batch;
mod sampling;
mod stride;
mod take;
#[cfg(test)]
mod touching_tests;

pub use crate::lanes::LANES;
pub use evaluate::{Output, evaluate};
pub use gather::RayQueue;
pub use marcher::Marcher;
pub use pipeline::{SampleSink, Stage, march};
pub use ray_packet::RayPacket;
pub(crate) use ray_slots::{RayLimits, RaySlot, RaySlots, SampleRun};
pub use ray_state::RayState;
pub use sample_batch::SampleBatch;
pub use sampling::{Hierarchical, MAX_SAMPLES, MAX_STEPS, Reach, Sampling};
pub use take::RUN;
