//! Cross-crate tests of pocketnerf; see `tests/`.

pub mod checksums;
pub mod damage;
mod data;
pub mod tiny;

pub use data::data;
