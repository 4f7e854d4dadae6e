//! Progress: a bar on a terminal, a line now and then in a pipe.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use pocketnerf_train::trainer::{MAX_RESTARTS, Progress};

use crate::commands::Common;
use crate::host::Hosted;

/// Seconds between two lines in a pipe.
const LINE_EVERY: u64 = 10;
/// Between two words to whoever watches.
const TELL: Duration = Duration::from_millis(250);
/// Between two pictures of what turns.
const TICK: Duration = Duration::from_millis(120);

/// Takes a line.
pub(super) type Line = Box<dyn Fn(&str)>;

/// Whoever watches a run.
pub(super) struct Screen {
    /// Takes a few words on how the run stands.
    pub(super) status: Line,
    /// Prints a line that stays, where the screen is the terminal.
    pub(super) line: Option<Line>,
}

/// Shows the progress of a run.
pub(in crate::commands) struct Bar {
    bar: Option<ProgressBar>,
    /// Who is told instead.
    host: Option<Hosted>,
    quiet: bool,
    last: Instant,
    /// Whether the bar shows how much is left.
    measured: bool,
    /// What the user should know, for `warnings` in JSON.
    warnings: Vec<String>,
    screen: Option<Screen>,
    /// When the first step was shown, and which it was.
    begun: Option<(Instant, u32)>,
    /// When whoever watches was told last.
    told: Instant,
}

impl Bar {
    pub(in crate::commands) fn new(common: &Common) -> Self {
        let terminal = !common.quiet && std::io::stderr().is_terminal();
        let mut bar = Self::on(terminal.then(ProgressBar::new_spinner), common.quiet);
        bar.host = common.host.clone();
        bar
    }

    /// The same, where somebody watches.
    #[cfg(feature = "view")]
    pub(super) fn beside(common: &Common, screen: Screen) -> Self {
        let mut bar = match screen.line {
            Some(_) => Self::on(None, common.quiet),
            None => Self::new(common),
        };
        bar.screen = Some(screen);
        bar
    }

    fn on(bar: Option<ProgressBar>, quiet: bool) -> Self {
        let last = Instant::now();
        Self {
            bar,
            host: None,
            quiet,
            last,
            measured: false,
            warnings: Vec::new(),
            screen: None,
            begun: None,
            told: last,
        }
    }

    /// Something begins whose length is not known, such as `reading the images`.
    pub(in crate::commands) fn phase(&mut self, what: &'static str) {
        if let Some(screen) = &self.screen {
            (screen.status)(what);
        }
        if let Some(Hosted(host)) = &self.host {
            host.phase(what);
        }
        match &self.bar {
            Some(bar) => {
                bar.set_style(style("{spinner} {msg}, {elapsed}"));
                bar.set_message(what);
                bar.enable_steady_tick(TICK);
            }
            None if self.is_on_screen() => {}
            None => self.say(what),
        }
        self.measured = false;
    }

    pub(in crate::commands) fn show(&mut self, progress: &Progress) {
        if let Some(trouble) = progress.trouble {
            self.begun = None;
            let n = progress.restarts;
            self.say(&format!("{trouble}: restarting ({n} of at most {MAX_RESTARTS} times)"));
        }
        if let Some(Hosted(host)) = &self.host {
            host.progress(progress);
        }
        self.tell(progress);
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
        } else if self.last.elapsed().as_secs() >= LINE_EVERY && !self.is_on_screen() {
            self.last = Instant::now();
            let steps = progress.steps.map_or_else(|| "?".to_owned(), |n| n.to_string());
            self.say(&format!("step {} of {steps}, {psnr}", progress.step));
        }
    }

    /// Something that the user should know of the data.
    pub(in crate::commands) fn note(&mut self, note: &str) {
        if let Some(Hosted(host)) = &self.host {
            host.warning(note);
        }
        self.say(&format!("note: {note}"));
        self.warnings.push(note.to_owned());
    }

    /// Something that may spoil the result: it is said in spite of `--quiet`.
    pub(in crate::commands) fn warn(&mut self, warning: String) {
        match &self.host {
            Some(Hosted(host)) => host.warning(&warning),
            None => self.print(&format!("warning: {warning}")),
        }
        self.warnings.push(warning);
    }

    /// All notes and warnings so far.
    pub(in crate::commands) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// A line that stays.
    pub(super) fn say(&self, line: &str) {
        if self.bar.is_some() || !self.quiet {
            self.print(line);
        }
    }

    fn print(&self, line: &str) {
        match (&self.bar, &self.screen) {
            (Some(bar), _) => bar.println(line),
            (None, Some(Screen { line: Some(print), .. })) => print(line),
            (None, _) => eprintln!("{line}"),
        }
    }

    /// Whether whoever watches does it where lines are printed.
    fn is_on_screen(&self) -> bool {
        self.screen.as_ref().is_some_and(|screen| screen.line.is_some())
    }

    /// Tells whoever watches how the run stands, a few times a second.
    fn tell(&mut self, progress: &Progress) {
        let Some(screen) = &self.screen else { return };
        let &mut (begun, first) = self.begun.get_or_insert_with(|| (Instant::now(), progress.step));
        if self.told.elapsed() < TELL {
            return;
        }
        self.told = Instant::now();
        let Progress { step, steps, train_psnr, .. } = *progress;
        let mut status = format!("step {step}");
        if let Some(steps) = steps {
            // A run that restarts begins anew.
            let pace = begun.elapsed().as_secs_f64() / f64::from(step.saturating_sub(first).max(1));
            let left = pace * f64::from(steps.saturating_sub(step));
            status += &format!(" of {steps}, {left:.0} s left");
        }
        (screen.status)(&format!("{status}, PSNR {train_psnr:.2} dB"));
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

    #[cfg(feature = "view")]
    #[test]
    fn whoever_watches_in_the_terminal_prints_all_lines() {
        use std::cell::RefCell;
        use std::rc::Rc;

        let (told, said) = (Rc::<RefCell<Vec<String>>>::default(), Rc::default());
        let to = |list: &Rc<RefCell<Vec<String>>>| -> Line {
            let list = Rc::clone(list);
            Box::new(move |line| list.borrow_mut().push(line.to_owned()))
        };
        let common = Common {
            threads: None,
            json: false,
            quiet: false,
            started: Instant::now(),
            host: None,
        };
        let mut bar = Bar::beside(&common, Screen { status: to(&told), line: Some(to(&said)) });
        bar.phase("finding the scene");
        let mut progress = Progress {
            step: 10,
            steps: Some(40),
            train_psnr: 9.5,
            held_out_psnr: None,
            restarts: 0,
            trouble: None,
        };
        bar.show(&progress);
        std::thread::sleep(TELL);
        progress.step = 40;
        bar.show(&progress);
        bar.warn("watch out".to_owned());
        bar.say("so it is");
        let last = "step 40 of 40, 0 s left, PSNR 9.50 dB";
        assert_eq!(*told.borrow(), ["finding the scene", last]);
        assert_eq!(*said.borrow(), ["warning: watch out", "so it is"]);
    }
}
