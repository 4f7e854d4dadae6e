//! The program `pocketnerf`: its commands, and what they need beside the library
//! `pocketnerf-train`.
//!
//! [`run_for`] runs a command for another program, such as the Python package; nothing else here
//! is meant for others.

#[doc(hidden)]
pub mod bench;
#[doc(hidden)]
pub mod chart;
mod commands;
#[doc(hidden)]
pub mod convert;
mod entry;
mod host;
#[doc(hidden)]
pub mod machine;
#[doc(hidden)]
pub mod stress;

pub use commands::{HeldDataset, hold};
pub use entry::{options, run, run_arguments, run_for};
pub use host::{Arguments, Host, Refusal, set_program};
