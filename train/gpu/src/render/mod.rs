//! A GPU, opened through wgpu, and the pictures that it renders. No type of wgpu leaves this
//! crate.

mod adapter;
mod band;
mod bands;
mod clock;
mod drawing;
mod error;
mod module;
mod picture;
mod program;
mod reading;
mod renderer;
mod self_test;
mod shown;

pub use adapter::{Gpu, Software, adapters};
pub(crate) use clock::Clock;
pub use error::Error;
pub use picture::Picture;
pub use renderer::Renderer;
