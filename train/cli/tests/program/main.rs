//! The program `pocketnerf`, as from a shell.

mod accidents;
mod bench;
mod chart;
mod convert;
mod data;
mod doubts;
mod eval;
mod export;
mod kinds;
mod packed;
mod page;
mod peers;
mod photographs;
mod place;
mod plain;
mod render;
mod resume;
mod stress;
mod surfaces;
#[cfg(feature = "view")]
mod view;
