//! Why a GPU does not render.

/// Why a GPU does not render. Every one of these is a reason to render on the CPU instead.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is none.
    #[error("no GPU was found")]
    NoAdapter,
    /// There is only a software GPU.
    #[error("no GPU was found but {0}, a software GPU that is slower than the CPU's own renderer")]
    Software(String),
    /// It cannot be opened.
    #[error("the GPU {name} cannot be opened: {reason}")]
    Open {
        /// What it is called.
        name: String,
        /// What its driver says.
        reason: String,
    },
    /// A model or a picture needs more memory at a time than it gives.
    #[error("{what} of {bytes} bytes are too many for the GPU, expected at most {most}")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// How large it is.
        bytes: u64,
        /// What there is room for.
        most: u64,
    },
    /// It cannot render what it is asked to.
    #[error("GPUs do not render {0}")]
    Unrenderable(&'static str),
    /// It cannot train what it is asked to.
    #[error("GPUs do not train {0}")]
    Untrainable(&'static str),
    /// The model cannot be rendered anywhere.
    #[error(transparent)]
    Model(#[from] pocketnerf_core::Error),
    /// The device stopped working, or refused to.
    #[error("the GPU failed: {0}")]
    Device(String),
    /// Its densities are not those of the CPU: by this part of the largest they differ, and may.
    #[error(
        "the GPU miscomputes: densities differ by {0:e} of the largest, expected at most {1:e}"
    )]
    MiscomputesDensities(f32, f32),
    /// Its pictures are not those of the CPU.
    #[error(
        "the GPU miscomputes: a picture of its own differs by {0:.1} dB, expected at least {1} dB"
    )]
    Miscomputes(f32, f32),
}
