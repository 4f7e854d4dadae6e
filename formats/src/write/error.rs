//! Why a file was not written, as values.

use core::fmt;

use crate::FormatError;
use crate::container::SectionId;
use crate::tensor_name::TensorName;

/// Why a file was not written.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteError {
    /// A weight is infinite or not a number.
    NotFinite(TensorName),
    /// A weight is too large for f16 at any allowed scale.
    OutOfRange(TensorName),
    /// The format has no code for a choice the model makes; the text names it.
    Unsupported(&'static str),
    /// Two sections of the same kind and index.
    Twice(SectionId),
    /// No reader would take the file.
    Unreadable(FormatError),
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(tensor) => {
                write!(f, "tensor {tensor}: holds a value that is infinite or not a number")
            }
            Self::OutOfRange(tensor) => {
                write!(f, "tensor {tensor}: holds a value too large for f16; f32 can hold it")
            }
            Self::Unsupported(what) => write!(f, "the format cannot express the model's {what}"),
            Self::Twice(section) => write!(f, "{section}: given twice"),
            Self::Unreadable(error) => write!(f, "{error}"),
        }
    }
}

impl core::error::Error for WriteError {}

impl From<FormatError> for WriteError {
    fn from(error: FormatError) -> Self {
        Self::Unreadable(error)
    }
}
