//! Accuracy against speed of many settings, measured in one run.
//!
//! A [`Point`] is one model rendered one way. [`plan`] lists what is trained, [`rounds`]
//! times pictures in turns, [`statistics`] summarises the times; [`frontier()`] and
//! [`bjontegaard`] compare, [`recommend`] chooses. [`peers`] reads points of other
//! programs. [`table`], [`drawing`] and [`page`] show them all.

mod axis;
pub mod bjontegaard;
pub mod drawing;
mod frontier;
pub mod page;
pub mod peers;
pub mod plan;
mod point;
pub mod provenance;
pub mod recommend;
pub mod rounds;
mod scale;
pub mod statistics;
pub mod table;

pub use axis::{Axis, Better};
pub use bjontegaard::Comparison;
pub use frontier::frontier;
pub use plan::Recipe;
pub use point::{Group, OURS, Point, groups};
pub use provenance::{MachineFacts, Program, Protocol};
pub use recommend::Wish;

use serde::Serialize;

/// A chart: the object in `points.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Chart {
    /// The program that trained and measured.
    pub program: Program,
    /// The machine.
    pub machine: MachineFacts,
    /// How it was measured.
    pub protocol: Protocol,
    /// Every two methods compared by one number.
    pub comparisons: Vec<Comparison>,
    /// The points.
    pub points: Vec<Point>,
}
