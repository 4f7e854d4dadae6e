//! Progress: a bar on a terminal, a line now and then in a pipe.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use pocketnerf_train::trainer::{MAX_RESTARTS, Progress};

/// Seconds between two lines in a pipe.
const LINE_EVERY: u64 = 10;
/// Between two pictures of what turns.
const TICK: Duration = Duration::from_millis(120);

/// Shows the progress of a run.
pub(in crate::commands) struct Bar {
    bar: Option<ProgressBar>,
    quiet: bool,
    last: Instant,
    /// Whether the bar shows how much is left.
    measured: bool,
    /// What the user should know, for `warnings` in JSON.
    warnings: Vec<String>,
}

impl Bar {
    pub(in crate::commands) fn new(quiet: bool) -> Self {
        let terminal = !quiet && std::io::stderr().is_terminal();
        Self::on(terminal.then(ProgressBar::new_spinner), quiet)
    }

    fn on(bar: Option<ProgressBar>, quiet: bool) -> Self {
        Self { bar, quiet, last: Instant::now(), measured: false, warnings: Vec::new() }
    }

    /// Something begins whose length is not known, such as `reading the images`.
    pub(in crate::commands) fn phase(&mut self, what: &'static str) {
        match &self.bar {
            Some(bar) => {
                bar.set_style(style("{spinner} {msg}, {elapsed}"));
                bar.set_message(what);
                bar.enable_steady_tick(TICK);
            }
            None => self.say(what),
        }
        self.measured = false;
    }

    pub(in crate::commands) fn show(&mut self, progress: &Progress) {
        if let Some(trouble) = progress.trouble {
            let n = progress.restarts;
            self.say(&format!("{trouble}: restarting ({n} of at most {MAX_RESTARTS} times)"));
        }
        let held_out = progress.held_out_psnr.map(|psnr| format!(", held-out {psnr:.2} dB"));
        let psnr =
            format!("training PSNR {:.2} dB{}", progress.train_psnr, held_out.unwrap_or_default());
        if let Some(bar) = &self.bar {
            if let Some(steps) = progress.steps {
                if !std::mem::replace(&mut self.measured, true) {
                    bar.disable_steady_tick();
                    bar.set_style(style(
                        "training {wide_bar} {pos}/{len} steps, {msg}, {eta} left",
                    ));
                }
                bar.set_length(u64::from(steps));
                bar.set_position(u64::from(progress.step));
                bar.set_message(psnr);
            } else {
                bar.set_message(format!("training, {} steps, {psnr}", progress.step));
            }
        } else if self.last.elapsed().as_secs() >= LINE_EVERY {
            self.last = Instant::now();
            let steps = progress.steps.map_or_else(|| "?".to_owned(), |n| n.to_string());
            self.say(&format!("step {} of {steps}, {psnr}", progress.step));
        }
    }

    /// Something that the user should know of the data.
    pub(in crate::commands) fn note(&mut self, note: &str) {
        self.say(&format!("note: {note}"));
        self.warnings.push(note.to_owned());
    }

    /// Something that may spoil the result: it is said in spite of `--quiet`.
    pub(in crate::commands) fn warn(&mut self, warning: String) {
        let line = format!("warning: {warning}");
        match &self.bar {
            Some(bar) => bar.println(line),
            None => eprintln!("{line}"),
        }
        self.warnings.push(warning);
    }

    /// All notes and warnings so far.
    pub(in crate::commands) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// A line that stays.
    pub(super) fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.println(line),
            None if !self.quiet => eprintln!("{line}"),
            None => {}
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("a valid template")
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use indicatif::{InMemoryTerm, ProgressDrawTarget};

    use super::*;

    #[test]
    fn a_bar_is_shown_once_its_length_is_known() {
        let terminal = InMemoryTerm::new(8, 100);
        let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
        let mut bar = Bar::on(Some(ProgressBar::with_draw_target(None, target)), false);
        bar.phase("finding the scene");
        assert!(terminal.contents().contains("finding the scene"), "{}", terminal.contents());
        let mut progress = Progress {
            step: 1,
            steps: None,
            train_psnr: 9.5,
            held_out_psnr: None,
            restarts: 0,
            trouble: None,
        };
        bar.show(&progress);
        let shown = terminal.contents();
        assert!(shown.contains("training, 1 steps, training PSNR 9.50 dB"), "{shown}");
        assert!(!shown.contains('/') && !shown.contains("left"), "{shown}");
        (progress.step, progress.steps) = (20, Some(40));
        progress.held_out_psnr = Some(9.25);
        bar.show(&progress);
        // Pictures are drawn a few times a second.
        std::thread::sleep(TICK);
        bar.warn("watch out".to_owned());
        let shown = terminal.contents();
        assert!(shown.contains("20/40 steps, training PSNR 9.50 dB, held-out 9.25 dB"), "{shown}");
        assert!(shown.starts_with("warning: watch out"), "{shown}");
        bar.phase("finishing the model");
        assert_eq!(bar.warnings(), ["watch out"]);
    }
}
