//! Trains radiance fields on ordinary CPUs.

pub mod dataset;
pub mod field;
pub mod random;
