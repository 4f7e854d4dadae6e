//! Which cells hold something.

pub(crate) mod cells;
pub(crate) mod clearing;
pub(crate) mod density_grid;
pub(crate) mod smoothing;
