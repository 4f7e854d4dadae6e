//! Why weights are refused, as values.

use std::io;
use std::path::PathBuf;

use pocketnerf_formats::import::ImportError;

/// Why a file of LPIPS weights was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LpipsError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {error}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// The container cannot be read.
    #[error("{}: {error}; LPIPS weights are read from .npz, as numpy.savez writes", .file.display())]
    Checkpoint {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        error: ImportError,
    },
    /// There are too few or too many of a kind of tensor.
    #[error(
        "{}: {found} {kind} where {expected} were expected; give LPIPS v0.1 weights, backbone and \
         heads in one file", .file.display()
    )]
    Count {
        /// The file.
        file: PathBuf,
        /// What is counted.
        kind: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: &'static str,
    },
    /// A tensor has another shape than it should.
    #[error(
        "{}: {name} has the shape {found:?} where {expected} was expected; give LPIPS v0.1 \
         weights of AlexNet or VGG16", .file.display()
    )]
    Shape {
        /// The file.
        file: PathBuf,
        /// The tensor, fit for one line.
        name: String,
        /// What it has.
        found: Vec<usize>,
        /// What it should have.
        expected: String,
    },
    /// A tensor holds other numbers than it may.
    #[error("{}: {name} {problem}; give LPIPS v0.1 weights of AlexNet or VGG16", .file.display())]
    Numbers {
        /// The file.
        file: PathBuf,
        /// The tensor, fit for one line.
        name: String,
        /// What is wrong with them.
        problem: &'static str,
    },
}
