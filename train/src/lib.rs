//! Trains radiance fields on ordinary CPUs.

mod aligned;
pub mod builtin;
pub mod cameras;
pub mod cli;
pub mod dataset;
pub mod evaluate;
pub mod field;
pub mod image_file;
pub mod json;
pub mod metrics;
pub mod output;
pub mod picture;
pub mod pose;
pub mod random;
pub mod trainer;
