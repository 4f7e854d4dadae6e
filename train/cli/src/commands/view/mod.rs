//! `pocketnerf view`: the program `pocketnerf-view`.

use pocketnerf_view::options::Options;
use pocketnerf_view::program;

use super::{Common, Failure};

#[derive(Debug, clap::Args)]
pub(super) struct View {
    #[command(flatten)]
    options: Options,
}

impl View {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        if common.json {
            return Err(
                "view: --json: expected none; `pocketnerf render --json` has figures".into()
            );
        }
        let threads = common.threads.unwrap_or(0).into();
        program::run(&self.options, threads).map_err(|failure| failure.to_string().into())
    }
}
