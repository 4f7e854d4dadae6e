//! `pocketnerf-view`: a window on a `.pnerf` file.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;
use pocketnerf_view::options::Options;
use pocketnerf_view::program;
use pocketnerf_view::window::input;

/// Shows a .pnerf file in a window, rendered on the CPU
#[derive(Debug, Parser)]
#[command(version, after_help = input::HELP)]
struct Arguments {
    #[command(flatten)]
    options: Options,
    /// Number of worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024),
        help_heading = "Common options")]
    threads: Option<u16>,
}

fn main() -> ExitCode {
    let Arguments { options, threads } = Arguments::parse();
    match program::run(&options, threads.unwrap_or(0).into()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("pocketnerf-view: {failure}");
            ExitCode::FAILURE
        }
    }
}
