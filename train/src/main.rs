//! The command line `pocketnerf`.
fn main() {}
