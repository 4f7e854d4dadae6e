//! Cross-crate tests of pocketnerf; see `tests/`.
