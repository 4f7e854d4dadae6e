//! `pocketnerf view` without the cargo feature `view`.

use std::ffi::OsString;

use super::{Common, Failure};

#[derive(Debug, clap::Args)]
pub(super) struct View {
    /// What the command takes where it is there.
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    options: Vec<OsString>,
}

impl View {
    pub(super) fn run(&self, _: &Common) -> Result<(), Failure> {
        Err(refusal("view").into())
    }
}

/// What to say where a window is asked for.
pub(super) fn refusal(what: &str) -> String {
    format!(
        "{what}: this program is built without windows; build it with --features view, as in \
         cargo install --path train/cli --features view"
    )
}
