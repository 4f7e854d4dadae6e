//! What may go wrong. Each message is one line, without the file's name.

/// Why a baseline is not trained, read or rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// Nothing to learn from.
    #[error("no photographs, expected at least one")]
    NoPhotographs,
    /// Too few of them.
    #[error("{found} photographs, expected at least {least} for this method")]
    TooFew {
        /// How many there are.
        found: usize,
        /// How many are needed.
        least: usize,
    },
    /// What is seen behind the scene must be known.
    #[error(
        "the background of these photographs is not known, expected images with alpha, or a plain \
         background: neural volumes are clouds before a known background; use another method"
    )]
    UnknownBackground,
    /// Numbers that are none.
    #[error("training diverged at step {0}; train with another --seed")]
    Diverged(u32),
    /// Not even a beginning.
    #[error("not a single step fits into {0} s; train longer")]
    NoTime(f64),
    /// Another kind of file.
    #[error("this is no baseline's file")]
    NotABaseline,
    /// A run that goes on was expected, or a finished one.
    #[error("this is {found}, expected {expected}")]
    Kind {
        /// What the file is.
        found: &'static str,
        /// What was asked for.
        expected: &'static str,
    },
    /// Bytes have changed, or are missing.
    #[error("this baseline's file is damaged: {0}; train it again")]
    Damaged(&'static str),
    /// Other photographs than the run began with.
    #[error("these are not the photographs that the run began with; give the same dataset")]
    OtherPhotographs,
}
