//! The program `pocketnerf`, as from a shell.

mod bench;
mod chart;
mod convert;
mod eval;
mod page;
mod peers;
mod render;
mod resume;
