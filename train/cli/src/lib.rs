//! The program `pocketnerf`: its commands, and what they need beside the library
//! `pocketnerf-train`.
//!
//! Nothing here is meant for other programs.

#[doc(hidden)]
pub mod bench;
#[doc(hidden)]
pub mod chart;
mod commands;
#[doc(hidden)]
pub mod convert;
#[doc(hidden)]
pub mod machine;
#[doc(hidden)]
pub mod stress;

pub use commands::run;
