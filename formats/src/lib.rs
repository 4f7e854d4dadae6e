//! The `.pnerf` model file.
#![no_std]
#![forbid(unsafe_code)]
