//! Networks for baselines: layers with their way back, in f32 for training and in f64 for tests of
//! gradients. Matrices are multiplied by ndarray.

mod adam;
mod block;
mod dense;
mod layout;
mod lstm;
mod real;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

pub(crate) use adam::{Adam, Moments};
pub(crate) use block::{Mlp, MlpTape};
pub(crate) use dense::Dense;
pub(crate) use layout::Layout;
pub(crate) use lstm::{Lstm, LstmTape};
pub(crate) use real::Real;
