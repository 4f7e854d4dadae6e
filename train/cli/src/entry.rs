//! How the program is run: as a process, or by another program in its own.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clap::error::ErrorKind;
use clap::{ArgAction, CommandFactory, Parser};
use pocketnerf_train::dataset::DatasetError;

use crate::commands::{Command, execute, is_interruption, saved, stop};
use crate::host::{Arguments, Host, Hosted, Refusal};

/// Runs the command of this process; `started` is when the program started.
#[must_use]
pub fn run(started: Instant) -> ExitCode {
    ExitCode::from(perform(Command::parse(), started))
}

/// Runs a command as [`run`] does, with these arguments instead of the process's own, and returns
/// the exit status.
#[must_use]
pub fn run_arguments(arguments: Arguments, started: Instant) -> u8 {
    match Command::try_parse_from(named(arguments)) {
        Ok(command) => perform(command, started),
        Err(error) => {
            // It is no error if nobody reads it.
            let _ = error.print();
            u8::try_from(error.exit_code()).unwrap_or(2)
        }
    }
}

fn perform(command: Command, started: Instant) -> u8 {
    match execute(&command.begun(started, None)) {
        Ok(()) => 0,
        Err(failure) => {
            eprintln!("pocketnerf: {failure}");
            if is_interruption(&failure) { stop::INTERRUPTED } else { 1 }
        }
    }
}

/// Runs a command for `host`, on the threads of the current pool, and prints nothing but help.
///
/// # Errors
/// Why there is no result.
pub fn run_for(host: Arc<dyn Host>, arguments: Arguments) -> Result<(), Refusal> {
    let quietly = arguments.into_iter().chain(["--json".into(), "--quiet".into()]);
    let command = Command::try_parse_from(named(quietly.collect())).map_err(usage)?;
    let command = command.begun(Instant::now(), Some(Hosted(host)));
    execute(&command).map_err(|failure| {
        let (line, checkpoint) = (failure.to_string(), saved(&failure));
        match is_interruption(&failure) {
            true => Refusal::Interrupted { line, checkpoint },
            false if failure.is::<DatasetError>() => Refusal::Dataset(line),
            false => Refusal::Failed { line, checkpoint },
        }
    })
}

/// The arguments behind the program's name.
fn named(arguments: Arguments) -> impl Iterator<Item = std::ffi::OsString> {
    std::iter::once("pocketnerf".into()).chain(arguments)
}

/// What is wrong with arguments, in one line; or the whole help that was asked for.
fn usage(error: clap::Error) -> Refusal {
    let text = error.to_string();
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return Refusal::Usage(text);
    }
    let lines = text.lines().map(str::trim).take_while(|line| !line.is_empty());
    let line = lines.collect::<Vec<_>>().join(" ");
    Refusal::Usage(line.strip_prefix("error: ").unwrap_or(&line).to_owned())
}

/// Options that [`run_for`] gives itself, or that end in a text for people.
const NOT_FOR_HOSTS: [&str; 4] = ["help", "json", "quiet", "version"];

/// The long options of a command for [`run_for`], each with `flag`, `value` or `values`: whether it takes no value,
/// one, or several; `None` if there is no such command.
#[must_use]
pub fn options(command: &str) -> Option<Vec<(String, &'static str)>> {
    let mut program = Command::command();
    program.build();
    let arguments = program.find_subcommand(command)?.get_arguments();
    let options = arguments.filter(|argument| !argument.is_hide_set()).filter_map(|argument| {
        let kind = match argument.get_action() {
            ArgAction::Append => "values",
            action if action.takes_values() => "value",
            _ => "flag",
        };
        let name = argument.get_long().filter(|name| !NOT_FOR_HOSTS.contains(name))?;
        Some((name.to_owned(), kind))
    });
    Some(options.collect())
}
