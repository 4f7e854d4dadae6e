//! The program `pocketnerf`, as from a shell.

mod accidents;
mod bench;
mod chart;
mod convert;
mod data;
mod doubts;
mod eval;
mod exposure;
mod packed;
mod page;
mod peers;
mod place;
mod plain;
mod refined;
mod render;
mod resume;
mod stress;
