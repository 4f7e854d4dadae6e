//! Which pixels a step learns from, and the rays through them.

pub(crate) mod alias_table;
mod backdrop;
pub(crate) mod exposure;
pub(crate) mod importance;
pub(crate) mod neighbours;
pub(crate) mod rays;
mod targets;
pub(crate) mod visibility;

pub use targets::Targets;
