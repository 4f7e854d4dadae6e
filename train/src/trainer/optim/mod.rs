//! How parameters follow their gradients.

pub(crate) mod adam;
pub(crate) mod muon;
pub(crate) mod schedule;
