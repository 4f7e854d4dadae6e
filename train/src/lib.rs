//! Trains radiance fields on ordinary CPUs.

pub mod builtin;
pub mod cameras;
pub mod dataset;
pub mod field;
pub mod image_file;
pub mod json;
pub mod metrics;
pub mod output;
pub mod pose;
pub mod random;
pub mod trainer;
