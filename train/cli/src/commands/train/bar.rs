//! Progress: a bar on a terminal, a line now and then in a pipe.

use std::io::IsTerminal;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use pocketnerf_train::trainer::{MAX_RESTARTS, Progress};

/// Seconds between two lines in a pipe.
const LINE_EVERY: u64 = 10;

/// Shows the progress of a run.
pub(in crate::commands) struct Bar {
    bar: Option<ProgressBar>,
    quiet: bool,
    last: Instant,
}

impl Bar {
    pub(in crate::commands) fn new(quiet: bool) -> Self {
        let terminal = !quiet && std::io::stderr().is_terminal();
        let style = "training {wide_bar} {pos}/{len} steps, {msg}, {eta} left";
        let bar = terminal.then(|| {
            let style = ProgressStyle::with_template(style).expect("a valid template");
            ProgressBar::new(0).with_style(style)
        });
        Self { bar, quiet, last: Instant::now() }
    }

    pub(in crate::commands) fn show(&mut self, progress: &Progress) {
        if let Some(trouble) = progress.trouble {
            let n = progress.restarts;
            self.say(&format!("{trouble}: restarting ({n} of at most {MAX_RESTARTS} times)"));
        }
        let psnr = format!("training PSNR {:.2} dB", progress.train_psnr);
        if let Some(bar) = &self.bar {
            bar.set_length(u64::from(progress.steps.unwrap_or(0)));
            bar.set_position(u64::from(progress.step));
            bar.set_message(psnr);
        } else if self.last.elapsed().as_secs() >= LINE_EVERY {
            self.last = Instant::now();
            let steps = progress.steps.map_or_else(|| "?".to_owned(), |n| n.to_string());
            self.say(&format!("step {} of {steps}, {psnr}", progress.step));
        }
    }

    /// A line that stays.
    fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.println(line),
            None if !self.quiet => eprintln!("{line}"),
            None => {}
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
