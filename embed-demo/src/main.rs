//! Renders an orbit of a `.pnerf` file.
fn main() {}
