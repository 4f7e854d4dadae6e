//! Single kernels on synthetic data: `cargo bench -p pocketnerf-tests`.
//!
//! `pocketnerf bench` tells what they cost in a picture or a training step.

mod adam;
mod composite;
mod dense;
mod encode;
mod march;
mod synthetic;

fn main() {
    divan::main();
}
