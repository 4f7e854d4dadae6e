//! Programs that run commands in a process of their own, such as the Python package.

use std::ffi::OsString;
use std::fmt;
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, OnceLock};

use pocketnerf_train::trainer::Progress;
use serde_json::Value;

/// What a command tells the program that runs it, instead of printing it. Called by the thread
/// that runs the command.
pub trait Host: Send + Sync {
    /// Something begins whose length is not known, such as `reading the images`.
    fn phase(&self, what: &str);

    /// A step of training.
    fn progress(&self, progress: &Progress);

    /// So many of a number of tasks are done.
    fn tasks(&self, what: &str, done: usize, all: usize);

    /// Something that may spoil the result.
    fn warning(&self, warning: &str);

    /// What `--json` prints.
    fn result(&self, result: Value);

    /// Whether the command is to end early; training saves a checkpoint then.
    fn is_asked_to_stop(&self) -> bool;
}

/// A host that commands share.
#[derive(Clone)]
pub(crate) struct Hosted(pub(crate) Arc<dyn Host>);

impl fmt::Debug for Hosted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Hosted")
    }
}

/// Why a command that a [`Host`] runs gave no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Its arguments make no sense.
    Usage(String),
    /// The host stopped it; a run of training is saved.
    Interrupted {
        /// One line.
        line: String,
        /// Where the run is saved.
        checkpoint: Option<PathBuf>,
    },
    /// A dataset cannot be read: one line.
    Dataset(String),
    /// Anything else: one line.
    Failed {
        /// What was found, what was expected, what to do.
        line: String,
        /// Where a run is saved whose model could not be written.
        checkpoint: Option<PathBuf>,
    },
}

/// What starts the program, where it is not the file that runs.
static PROGRAM: OnceLock<Arguments> = OnceLock::new();

/// Says what starts the program, once: a file and its first arguments. Commands that run others
/// of it in processes of their own need it where they do not run in the program itself.
pub fn set_program(program: Arguments) {
    // Whoever was first stays.
    let _ = PROGRAM.set(program);
}

/// The program, to be run in a process of its own.
pub(crate) fn program() -> std::io::Result<Command> {
    Ok(match PROGRAM.get().map(Vec::as_slice) {
        Some([file, first @ ..]) => {
            let mut command = Command::new(file);
            command.args(first);
            command
        }
        _ => Command::new(std::env::current_exe()?),
    })
}

/// A command of the program and its options, as on a command line without the program's name.
pub type Arguments = Vec<OsString>;
