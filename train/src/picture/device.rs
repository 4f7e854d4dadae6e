//! What pictures are rendered on.

/// What pictures are rendered on. Without the cargo feature `gpu` there is the CPU alone.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum Device {
    /// The threads of the current pool.
    #[default]
    Cpu,
    /// A GPU that is open. What it cannot do, the CPU does: see
    /// [`Renderer::fallback`](super::Renderer::fallback).
    #[cfg(feature = "gpu")]
    Gpu(pocketnerf_gpu::Gpu),
}
