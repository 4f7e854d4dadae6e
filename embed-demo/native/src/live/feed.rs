//! What passes between whoever learns a model and whoever shows it.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use pocketnerf_core::render::RenderStats;

use crate::paint::modes::Mode;
use crate::paint::picture::Picture;
use crate::view::View;

/// What passes between a thread that learns a model and those that show it. Clones are the same
/// feed.
///
/// The learner asks [`is_wanted`](Self::is_wanted) between two steps, which is one read, and then
/// [gives](Self::give) the bytes of a `.pnerf` file.
#[derive(Clone, Debug, Default)]
pub struct Feed(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    wanted: AtomicBool,
    left: AtomicBool,
    state: Mutex<State>,
    changed: Condvar,
}

/// All that the threads tell each other.
#[derive(Debug, Default)]
pub(super) struct State {
    /// The newest model, until it is taken.
    pub(super) given: Option<Given>,
    /// How the learner stands.
    pub(super) status: String,
    /// Lines of the learner that are not printed yet.
    pub(super) lines: Vec<String>,
    /// Whether the finished model was given.
    pub(super) finished: bool,
    /// Whether there will be no further model.
    pub(super) over: bool,
    /// The view of the model's own camera, once there is a model.
    pub(super) start: Option<View>,
    /// What is to be painted.
    pub(super) wish: Option<Wish>,
    /// The newest picture, until it is taken.
    pub(super) frame: Option<Frame>,
    /// Seconds that showing pictures has taken since the painter asked last.
    pub(super) showing: f64,
    /// Why nothing is painted any more.
    pub(super) failure: Option<String>,
}

/// A model to be shown.
#[derive(Debug)]
pub(super) struct Given {
    pub(super) bytes: Vec<u8>,
    /// For how long the learner waited for it.
    pub(super) took: Duration,
    /// Whether it is the last one.
    pub(super) is_final: bool,
}

/// What is to be painted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wish {
    pub(super) view: View,
    pub(super) mode: Mode,
    /// Quality of the complete picture.
    pub(super) quality: f32,
    /// Pictures a second once the model is finished.
    pub(super) fps: f64,
    pub(super) size: [u32; 2],
}

/// A picture.
#[derive(Debug)]
pub(super) struct Frame {
    /// What was wished for.
    pub(super) wish: Wish,
    pub(super) picture: Picture,
    /// Rendered width, as a fraction of the picture's.
    pub(super) scale: f64,
    /// Whether it is the complete picture of the finished model.
    pub(super) is_complete: bool,
    /// Rays and samples of it.
    pub(super) stats: RenderStats,
    /// When it was begun.
    pub(super) begun: Instant,
}

impl Feed {
    /// Whether a model is wanted now.
    #[must_use]
    pub fn is_wanted(&self) -> bool {
        self.0.wanted.load(SeqCst)
    }

    /// Gives the model as it stands, which `took` so long to write. `None`: it cannot be written
    /// now.
    pub fn give(&self, bytes: Option<Vec<u8>>, took: Duration) {
        self.change(|state| {
            self.0.wanted.store(false, SeqCst);
            if let Some(bytes) = bytes {
                state.given = Some(Given { bytes, took, is_final: false });
            }
        });
    }

    /// Gives the finished model.
    pub fn finish(&self, bytes: Vec<u8>) {
        let took = Duration::ZERO;
        self.change(|state| {
            self.0.wanted.store(false, SeqCst);
            state.finished = true;
            state.given = Some(Given { bytes, took, is_final: true });
        });
    }

    /// There will be no further model.
    pub fn end(&self) {
        self.change(|state| state.over = true);
    }

    /// How the learner stands, a few words.
    pub fn tell(&self, status: &str) {
        self.change(|state| status.clone_into(&mut state.status));
    }

    /// A line to print where pictures fill the terminal.
    pub fn say(&self, line: &str) {
        self.change(|state| state.lines.push(line.to_owned()));
    }

    /// Whether nobody looks any more.
    #[must_use]
    pub fn is_left(&self) -> bool {
        self.0.left.load(SeqCst)
    }

    /// Waits until nobody looks any more.
    pub fn wait_until_left(&self) {
        drop(self.wait(None, |_| self.is_left()));
    }

    /// Nobody looks any more.
    pub fn leave(&self) {
        self.change(|_| {
            self.0.left.store(true, SeqCst);
            self.0.wanted.store(false, SeqCst);
        });
    }

    /// A model is wanted, as soon as the learner has time.
    pub(super) fn want(&self) {
        let _state = self.state();
        self.0.wanted.store(!self.is_left(), SeqCst);
    }

    /// Wants the first model, and waits for it; its bytes, unless there is none.
    pub(super) fn first<T>(&self, look: impl FnOnce(&[u8]) -> T) -> Option<T> {
        self.want();
        let state = self.wait(None, |state| state.given.is_some() || state.over);
        state.given.as_ref().map(|given| look(&given.bytes))
    }

    /// Changes the state, and tells all threads.
    pub(super) fn change<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        let changed = change(&mut self.state());
        self.0.changed.notify_all();
        changed
    }

    /// The state, where nobody has to know that it changes.
    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        // A picture or a model at worst is missing.
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until the state is as wanted, or for a time.
    pub(super) fn wait(
        &self,
        until: Option<Instant>,
        ready: impl Fn(&State) -> bool,
    ) -> MutexGuard<'_, State> {
        let mut state = self.state();
        while !ready(&state) {
            let changed = &self.0.changed;
            state = match until.map(|until| until.saturating_duration_since(Instant::now())) {
                None => changed.wait(state).unwrap_or_else(PoisonError::into_inner),
                Some(Duration::ZERO) => return state,
                Some(left) => {
                    let waited = changed.wait_timeout(state, left);
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_given_where_they_are_wanted() {
        let feed = Feed::default();
        assert!(!feed.is_wanted());
        let learner = feed.clone();
        let thread = std::thread::spawn(move || {
            while !learner.is_wanted() {
                std::thread::yield_now();
            }
            learner.give(Some(vec![7]), Duration::ZERO);
        });
        assert_eq!(feed.first(<[u8]>::to_vec), Some(vec![7]));
        thread.join().unwrap();
        assert!(!feed.is_wanted());
        feed.want();
        feed.leave();
        assert!(feed.is_left() && !feed.is_wanted());
        feed.want();
        assert!(!feed.is_wanted());
        feed.wait_until_left();
    }

    #[test]
    fn nobody_waits_for_a_model_that_never_comes() {
        let feed = Feed::default();
        feed.end();
        assert_eq!(feed.first(<[u8]>::len), None);
        let soon = Instant::now() + Duration::from_millis(1);
        assert!(feed.wait(Some(soon), |_| false).given.is_none());
    }
}
