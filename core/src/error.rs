//! What can be wrong with a model, as values.

use core::fmt;

/// Why a model, a tensor or a request was refused.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A tensor's bytes do not hold `shape[0] * shape[1]` values of its type.
    TensorLength {
        /// Bytes that the shape needs.
        expected: usize,
        /// Bytes that are there.
        found: usize,
    },
    /// Two parts of a model do not fit together; the text names them.
    Shape(&'static str),
    /// A number lies outside what the format allows; the text names it.
    Range(&'static str),
    /// The caller's scratch slice is too short.
    ScratchTooSmall {
        /// `f32` values needed.
        needed: usize,
        /// `f32` values given.
        given: usize,
    },
    /// The caller's output slice does not hold the requested pixels.
    OutputLength {
        /// Values needed.
        needed: usize,
        /// Values given.
        given: usize,
    },
    /// One of the caller's input slices does not fit the other.
    InputLength {
        /// Values needed.
        needed: usize,
        /// Values given.
        given: usize,
    },
    /// The question has no answer in a model like this; the text says which.
    Unsupported(&'static str),
    /// The model is larger than the [`Limits`](crate::scratch::Limits) the scratch was sized for.
    Limits(&'static str),
    /// This build leaves out the requested cargo feature.
    Feature(&'static str),
    /// Rendering would take more samples than the caller allows.
    TooManySamples {
        /// Samples allowed, all pixels together.
        allowed: u64,
    },
    /// The machine (or this build) lacks the requested SIMD level.
    SimdUnavailable(crate::simd::SimdLevel),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TensorLength { expected, found } => {
                write!(f, "a tensor holds {found} bytes where its shape needs {expected}")
            }
            Self::Shape(what) => write!(f, "parts of the model do not fit together: {what}"),
            Self::Range(what) => write!(f, "a value lies outside its allowed range: {what}"),
            Self::ScratchTooSmall { needed, given } => {
                write!(f, "scratch holds {given} values where {needed} are needed")
            }
            Self::OutputLength { needed, given } => {
                write!(f, "output holds {given} values where {needed} are needed")
            }
            Self::InputLength { needed, given } => {
                write!(f, "input holds {given} values where {needed} are needed")
            }
            Self::Unsupported(what) => write!(f, "the model cannot answer this: {what}"),
            Self::Limits(what) => write!(f, "the model exceeds the limits given: {what}"),
            Self::Feature(name) => {
                write!(f, "this build leaves it out: it needs the cargo feature `{name}`")
            }
            Self::TooManySamples { allowed } => {
                write!(f, "rendering takes more than the {allowed} samples allowed")
            }
            Self::SimdUnavailable(level) => {
                write!(f, "this machine or build has no SIMD level `{level}`")
            }
        }
    }
}

impl core::error::Error for Error {}
