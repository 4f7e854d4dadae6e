//! Why a checkpoint's tensors are not a field that is known, as values.

use core::fmt;
use std::string::String;
use std::vec::Vec;

use super::error::shown;
use super::{Checkpoint, ImportError};

/// Why a checkpoint's tensors are not those of a field that is known.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FieldError {
    /// None of the tensors has a name that a known program gives.
    Unknown {
        /// The first tensors in the file.
        found: Vec<String>,
    },
    /// A tensor that the network needs is not there.
    Missing(String),
    /// A tensor of the network's that no network of this program has.
    Extra(String),
    /// A tensor's shape is not what the others ask for.
    Shape {
        /// The tensor.
        name: String,
        /// Its shape.
        found: Vec<usize>,
        /// What it should be.
        expected: String,
    },
    /// So many values encode a position or a direction.
    Encoding {
        /// Which of both.
        what: &'static str,
        /// How many.
        found: usize,
    },
    /// A value is infinite or not a number.
    NotFinite(String),
    /// More layers than a model may have.
    Layers(usize),
    /// A value of the checkpoint, or what follows from its shapes, that no model has.
    Setting {
        /// What it is called.
        name: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// The tensor cannot be read.
    Tensor(String, ImportError),
}

impl FieldError {
    /// No name that a known program gives.
    pub(super) fn unknown(checkpoint: &Checkpoint<'_>) -> Self {
        let found = checkpoint.names().take(SHOWN).map(String::from).collect();
        Self::Unknown { found }
    }
}

/// Names that are shown of a file that is not known.
const SHOWN: usize = 4;

impl core::error::Error for FieldError {}

impl fmt::Display for FieldError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { found } => {
                write!(f, "no network of a known program: the tensors are")?;
                found.iter().try_for_each(|name| write!(f, " {}", shown(name)))?;
                write!(
                    f,
                    ", expected those of nerf-pytorch, nerf_pl, the original program, torch-ngp, \
                     ngp_pl, nerfstudio's instant-ngp, TensoRF or svox2 (pts_linears.0.weight, \
                     layer1.weight, xyz_encoding_1.0.weight, encoder.embeddings, ...)"
                )
            }
            Self::Missing(name) => write!(f, "{}: the network needs it, not there", shown(name)),
            Self::Extra(name) => {
                write!(f, "{}: no part of such a network, another kind of field?", shown(name))
            }
            Self::Shape { name, found, expected } => {
                write!(f, "{}: shape {found:?}, expected {expected}", shown(name))
            }
            Self::Encoding { what, found } => write!(
                f,
                "{found} values of a {what}, expected 3 and a multiple of 6, or a multiple of 6"
            ),
            Self::NotFinite(name) => {
                write!(f, "{}: a value is infinite or not a number", shown(name))
            }
            Self::Setting { name, found, expected } => {
                write!(f, "{}: {}, expected {expected}", shown(name), shown(found))
            }
            Self::Layers(found) => write!(f, "{found} layers, more than a model may have"),
            Self::Tensor(name, error) => write!(f, "{}: {error}", shown(name)),
        }
    }
}
