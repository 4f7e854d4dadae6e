//! Why a run cannot be resumed: one line each, with the file, what was found,
//! what was expected and what to do.

use std::path::{Path, PathBuf};

use pocketnerf_formats::{FormatError, SectionId};

use crate::json::{escape, one_line};
use crate::trainer::prepass::PrepassError;

/// A checkpoint that cannot be resumed. The message is one line.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", one_line(.file))]
pub struct CheckpointError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    #[source]
    pub problem: Problem,
}

/// What is wrong with a checkpoint.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The system refused.
    #[error("cannot be read: {0}; check the path and its permissions")]
    Unreadable(#[source] std::io::Error),
    /// The file is damaged, or no file of ours.
    #[error(
        "{0}; expected a checkpoint; resume from another one or train from scratch without --resume"
    )]
    Format(#[from] FormatError),
    /// A model without a trainer's state.
    #[error(
        "this is a model, expected a checkpoint; give the file that ends in .ckpt.pnerf, \
         or train from scratch without --resume"
    )]
    NotACheckpoint,
    /// Another version of this program wrote it.
    #[error(
        "{section}: version {found} where {} was expected; \
         resume with the version of this program that wrote it",
        super::V1
    )]
    Version {
        /// The section.
        section: SectionId,
        /// Its version.
        found: u16,
    },
    /// A section is not as long as the model asks for.
    #[error(
        "{section}: {found} bytes where {expected} were expected: the file is damaged; \
         resume from another checkpoint or train from scratch without --resume"
    )]
    Length {
        /// The section.
        section: SectionId,
        /// Bytes that the model asks for.
        expected: u64,
        /// Bytes that are there.
        found: u64,
    },
    /// The trainer's state makes no sense.
    #[error(
        "the trainer's state cannot be used: {0} is unreadable or outside its range; \
         resume from another checkpoint or train from scratch without --resume"
    )]
    State(&'static str),
    /// A model that no trainer of ours works on.
    #[error(
        "the model in it is not one that training makes ({0}), expected a hash grid \
         or another field in f32; train from scratch without --resume"
    )]
    Untrainable(&'static str),
    /// The run was on another dataset.
    #[error(
        "trained on \"{}\" (fingerprint {expected:016x}), but \"{}\" has fingerprint {found:016x}; \
         give the dataset that the run began with, unchanged",
        escape(.name), escape(.given)
    )]
    Dataset {
        /// Name of the dataset in the checkpoint.
        name: String,
        /// The dataset given.
        given: String,
        /// Fingerprint in the checkpoint.
        expected: u64,
        /// Fingerprint of the dataset given.
        found: u64,
    },
    /// An option says something else than the checkpoint.
    #[error(
        "trained with {}, but {option} {given} was given; \
         leave {option} out when resuming, or train from scratch without --resume",
        .stored.as_ref().map_or_else(|| format!("no {option}"), |v| format!("{option} {v}"))
    )]
    Option {
        /// The option.
        option: &'static str,
        /// Its value on the command line.
        given: String,
        /// Its value in the checkpoint.
        stored: Option<String>,
    },
    /// The settings do not make a field, or the machine lacks the SIMD level.
    #[error("{0}; train from scratch without --resume")]
    Model(#[source] PrepassError),
    /// This build makes something else of the same data.
    #[error(
        "this build does not find the same {0} in the dataset; \
         resume with the version of this program that wrote the checkpoint"
    )]
    Changed(&'static str),
}

impl Problem {
    /// The problem of a file.
    #[must_use]
    pub fn of(self, file: &Path) -> CheckpointError {
        CheckpointError { file: file.to_owned(), problem: self }
    }
}
