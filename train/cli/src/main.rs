//! The command line `pocketnerf`.

use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    pocketnerf_cli::run(Instant::now())
}
