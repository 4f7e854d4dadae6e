//! Trains radiance fields on ordinary CPUs.

pub mod builtin;
pub mod dataset;
