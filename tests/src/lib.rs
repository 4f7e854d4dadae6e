//! Cross-crate tests of pocketnerf; see `tests/`.

pub mod checksums;
pub mod damage;
pub mod tiny;
