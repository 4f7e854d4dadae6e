//! Datasets: what is told of them, and how they are made.

mod info;
#[cfg(unix)]
mod prepare;
#[cfg(unix)]
mod real;
#[cfg(unix)]
mod shop;
mod world;
