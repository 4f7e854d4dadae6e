//! How a command is asked to stop: by Ctrl-C, and where there are such signals by SIGTERM and
//! SIGHUP.

use std::fmt;
use std::process::{Child, ExitStatus};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use super::{Common, Failure};
use crate::host::Hosted;

/// Exit status of a program that Ctrl-C ended, by the convention of shells: 128 plus the
/// number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;

/// Signals this close together count as one: supervisors signal a program and then its
/// process group.
const SAME_KEY: Duration = Duration::from_millis(500);

/// Whether the command is to stop.
#[derive(Clone, Default)]
pub(super) struct Stop {
    state: Arc<State>,
    /// Who says so in place of signals.
    host: Option<Hosted>,
}

#[derive(Default)]
struct State {
    asked: AtomicBool,
    /// Whether the command looks at `asked`. Until then the first signal ends the program.
    deferred: AtomicBool,
    /// Whether the work is done, so that a signal ends a program that goes on.
    done: AtomicBool,
    /// A program that is to stop as well; 0: none.
    child: AtomicU32,
}

/// A signal ended work that continues where it was.
#[derive(Debug)]
pub(super) struct Interrupted;

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("interrupted; run the same command again to continue")
    }
}

impl std::error::Error for Interrupted {}

/// Whether a run of the program ended by Ctrl-C: in training with a status of its own, before
/// that by the signal.
pub(super) fn was_interrupted(status: ExitStatus) -> bool {
    #[cfg(unix)]
    if std::os::unix::process::ExitStatusExt::signal(&status) == Some(2) {
        return true; // SIGINT
    }
    status.code() == Some(INTERRUPTED.into())
}

impl Stop {
    /// From now on the first signal ends the program with [`INTERRUPTED`], after a line that
    /// says what came of it; or a host says when the command is to stop.
    pub(super) fn listen(common: &Common, outcome: &'static str) -> Result<Self, Failure> {
        let stop = Self { host: common.host.clone(), ..Self::default() };
        if stop.host.is_some() {
            return Ok(stop);
        }
        let heard = stop.clone();
        let mut first = None;
        ctrlc::set_handler(move || {
            let State { asked, deferred, done, .. } = &*heard.state;
            if done.load(Ordering::SeqCst) {
                std::process::exit(0);
            }
            asked.store(true, Ordering::SeqCst);
            heard.pass_on();
            if !deferred.load(Ordering::SeqCst) {
                eprintln!("pocketnerf: {outcome}");
                std::process::exit(INTERRUPTED.into());
            }
            if first.get_or_insert_with(Instant::now).elapsed() > SAME_KEY {
                std::process::exit(INTERRUPTED.into());
            }
        })?;
        Ok(stop)
    }

    /// From now on the command stops by itself, where it [is asked](Self::is_asked) to; a second
    /// signal still ends the program.
    pub(super) fn defer(&self) {
        self.state.deferred.store(true, Ordering::SeqCst);
    }

    /// From now on a signal ends the program, and that is success.
    pub(super) fn done(&self) {
        self.state.done.store(true, Ordering::SeqCst);
    }

    /// Whether there was a signal, or the host wants the command to end.
    pub(super) fn is_asked(&self) -> bool {
        let Hosted(host) = match &self.host {
            None => return self.state.asked.load(Ordering::SeqCst),
            Some(host) => host,
        };
        host.is_asked_to_stop()
    }

    /// Ends long work between two of its parts, where there was a signal.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if self.is_asked() { Err(Interrupted.into()) } else { Ok(()) }
    }

    /// Passes signals on to a child that the program waits for; `None`: no longer.
    pub(super) fn child(&self, child: Option<&Child>) {
        self.state.child.store(child.map_or(0, Child::id), Ordering::SeqCst);
        // The signal may have come before there was a child.
        if self.is_asked() {
            self.pass_on();
        }
    }

    /// Asks the child to stop. A terminal signals it too, which counts as the same key.
    fn pass_on(&self) {
        #[cfg(unix)]
        if let Ok(id @ 1..) = i32::try_from(self.state.child.load(Ordering::SeqCst)) {
            use nix::sys::signal::{Signal, kill};
            // It may have ended just now.
            let _ = kill(nix::unistd::Pid::from_raw(id), Signal::SIGINT);
        }
    }
}
