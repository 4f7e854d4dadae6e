//! The renderer against the oracle, `pocketnerf_core::reference`: every kind of
//! field, every stored type, every shading, at every SIMD level of this machine.

mod agreement;
mod gpu;
mod hierarchical;
mod hostile;
mod invariants;
mod models;
mod ndc;
mod nerf;
mod picture;
mod query;
mod recipes;
mod refusals;
