//! Progress of long work: a bar on a terminal, a line now and then in a pipe.

use std::io::IsTerminal;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};

use super::Common;
use crate::host::Hosted;

/// Seconds between two lines in a pipe.
const LINE_EVERY: u64 = 10;

/// A number of tasks, one after the other.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    host: Option<Hosted>,
    quiet: bool,
    what: &'static str,
    all: usize,
    last: Instant,
}

impl Progress {
    pub(super) fn new(what: &'static str, all: usize, common: &Common) -> Self {
        let (quiet, host) = (common.quiet, common.host.clone());
        let terminal = !quiet && std::io::stderr().is_terminal();
        let bar = terminal.then(|| {
            let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} left");
            let style = style.expect("a valid template");
            ProgressBar::new(all as u64).with_style(style).with_message(what)
        });
        Self { bar, host, quiet, what, all, last: Instant::now() }
    }

    /// Reports the number of finished tasks.
    pub(super) fn done(&mut self, n: usize) {
        if let Some(Hosted(host)) = &self.host {
            host.tasks(self.what, n, self.all);
        } else if let Some(bar) = &self.bar {
            bar.set_position(n as u64);
        } else if !self.quiet && self.last.elapsed().as_secs() >= LINE_EVERY {
            self.last = Instant::now();
            eprintln!("{}: {n} of {}", self.what, self.all);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// A duration for people.
pub(super) fn duration(seconds: f64) -> String {
    match seconds {
        ..100.0 => format!("{seconds:.0} s"),
        ..6000.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}
