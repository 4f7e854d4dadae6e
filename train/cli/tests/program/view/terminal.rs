//! Pictures of a run in a terminal, which tmux is.

use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use super::{STEPS, alone, said};
use crate::place::{Place, TRAIN};

/// After this a test has failed, however slow the machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A server of its own, with one terminal.
struct Terminal<'p>(&'p Path);

impl Drop for Terminal<'_> {
    fn drop(&mut self) {
        let _ = self.tmux(&["kill-server"]);
    }
}

impl Terminal<'_> {
    fn tmux(&self, arguments: &[&str]) -> std::io::Result<std::process::Output> {
        let mut command = Command::new("tmux");
        command.arg("-S").arg(self.0.join("tmux")).args(["-f", "/dev/null"]).args(arguments);
        for display in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET", "TMUX"] {
            command.env_remove(display);
        }
        command.current_dir(self.0).output()
    }

    /// Runs a shell's line in a terminal of 80 by 24; false, and a word about it, without tmux: that
    /// is a failure where POCKETNERF_REQUIRE_TOOLS is set.
    fn run(&self, line: &str) -> bool {
        match self.tmux(&["new-session", "-d", "-x", "80", "-y", "24", line]) {
            Ok(output) => {
                assert!(output.status.success(), "{}", said(&output));
                true
            }
            Err(e) => {
                assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "tmux: {e}");
                // Past the test harness, which keeps what tests that pass have printed.
                let _ = writeln!(std::io::stderr(), "SKIPPED: tmux: {e}; apt-get install tmux");
                false
            }
        }
    }

    /// What the terminal shows, with its colours.
    fn shown(&self) -> String {
        let output = self.tmux(&["capture-pane", "-p", "-e"]).unwrap();
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    fn wait_for(&self, what: &str, ready: impl Fn(&str) -> bool) -> String {
        let begun = Instant::now();
        loop {
            let shown = self.shown();
            if ready(&shown) {
                return shown;
            }
            assert!(begun.elapsed() < PATIENCE, "waited in vain for {what}: {shown}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

#[test]
fn a_scene_appears_as_text_and_the_last_picture_stays() {
    let place = Place::new();
    let folder = place.path("");
    let terminal = Terminal(&folder);
    let program = env!("CARGO_BIN_EXE_pocketnerf");
    let train = TRAIN.replace("--json --quiet ", "");
    // Without a display, --view is --view=terminal, and says so.
    let line =
        format!("{program} {train} --steps {STEPS} --out seen.pnerf --view; echo status $?; cat");
    if !terminal.run(&line) {
        return;
    }
    let is_picture = |shown: &str| shown.contains('▀') && shown.contains("\x1b[38;2;");
    let early =
        terminal.wait_for("a picture", |shown| is_picture(shown) && shown.contains("step "));
    let later = terminal.wait_for("another one", |shown| shown != early && is_picture(shown));
    // Pictures lie one over the other.
    let rows = |shown: &str| shown.lines().filter(|line| line.contains('▀')).count();
    assert_eq!(rows(&early), rows(&later), "{early}{later}");
    let last = terminal.wait_for("the end", |shown| shown.contains("status "));
    assert!(last.contains("status 0") && last.contains("seen.pnerf: "), "{last}");
    assert!(is_picture(&last) && rows(&last) + 3 >= rows(&early), "{last}");
    assert!(place.bytes("seen.pnerf") == alone());
}

#[test]
fn where_nothing_can_be_shown_a_line_says_so() {
    let place = Place::new();
    for (option, begin) in [
        ("--view", "--view: no window: "),
        ("--view=window", "--view: no window: "),
        ("--view=terminal", "--view=terminal: standard error is no terminal; leave it out"),
    ] {
        let mut command = place.command(&format!("{TRAIN} --steps 5 --out seen.pnerf {option}"));
        for display in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(display);
        }
        let output = command.output().unwrap();
        let line = said(&output);
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(line.starts_with(&format!("pocketnerf: {begin}")), "{line}");
        assert!(line.matches('\n').count() == 1 && line.ends_with("leave it out\n"), "{line}");
        assert!(!place.path("seen.pnerf").exists());
    }
}
