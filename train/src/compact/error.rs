//! Why a model was not made smaller.

/// A model that cannot be made that small, in one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CompactError {
    /// Even the coarsest steps take more.
    #[error("{most} bytes are too few, expected at least {least}: train with fewer entries")]
    TooSmall {
        /// Bytes asked for.
        most: usize,
        /// About the least that is possible.
        least: usize,
    },
    /// The kind of field has no tables.
    #[error("the model has no tables to be rounded, expected a hash grid or planes")]
    NoTables,
    /// It cannot be rendered.
    #[error(transparent)]
    Render(#[from] pocketnerf_core::Error),
    /// It cannot be opened.
    #[error(transparent)]
    Format(#[from] pocketnerf_formats::FormatError),
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] pocketnerf_formats::WriteError),
}
