//! A GPU, opened through wgpu, and the pictures that it renders. No type of wgpu leaves this
//! folder.

mod adapter;
mod bands;
mod error;
mod picture;
mod program;
mod renderer;
mod self_test;

pub use adapter::{Gpu, Software, adapters};
pub use error::Error;
pub use picture::Picture;
pub use renderer::Renderer;
