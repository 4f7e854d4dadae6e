//! Trains radiance fields on ordinary CPUs.

pub mod dataset;
