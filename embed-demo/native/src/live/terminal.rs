//! Pictures in a terminal of a model that is still learnt.

use std::fmt::Write as _;
use std::io::{Write as _, stderr};
use std::time::{Duration, Instant};

use super::feed::{Feed, State, Wish};
use super::painting::Painting;
use crate::Failure;
use crate::output::terminal::{fit, room, text};
use crate::paint::modes::Mode;
use crate::paint::picture::Picture;
use crate::view::View;

/// Views of a turn around the scene, ...
const VIEWS: u32 = 180;
/// ... and how long each is shown.
const VIEW: Duration = Duration::from_millis(330);
/// Quality of the last picture.
const QUALITY: f32 = 0.5;

/// Shows pictures on standard error, one over the other, until the finished model is shown or there
/// is nothing more to see. The view turns slowly. The learner has so many `cores`, and its lines
/// and its status are printed here.
///
/// # Errors
/// One line: what cannot be painted.
pub fn run(feed: &Feed, cores: usize) -> Result<(), Failure> {
    let outcome = std::thread::scope(|scope| {
        let painter = scope.spawn(|| {
            let outcome = Painting::new(feed, cores, &|| ()).and_then(Painting::run);
            feed.leave();
            outcome
        });
        watch(feed);
        feed.leave();
        painter.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    });
    Ok(outcome?)
}

fn watch(feed: &Feed) {
    feed.want();
    let (mut screen, mut turn) = (Screen::default(), None);
    let (mut status, mut picture) = (String::new(), Picture::default());
    loop {
        let ready = |state: &State| {
            let begins = turn.is_none() && state.start.is_some();
            let is_new = state.frame.is_some() || !state.lines.is_empty();
            is_new || begins || state.status != status || feed.is_left()
        };
        let next = turn.as_ref().map(|turn: &Turn| turn.next);
        let mut state = feed.wait(next, ready);
        turn = turn.or_else(|| state.start.as_ref().map(Turn::new));
        let (lines, frame) = (std::mem::take(&mut state.lines), state.frame.take());
        let is_last = feed.is_left() || frame.as_ref().is_some_and(|frame| frame.is_complete);
        let told = std::mem::replace(&mut status, state.status.clone());
        drop(state);
        if !lines.is_empty() || frame.is_some() {
            picture = frame.map_or(picture, |frame| frame.picture);
            screen.draw(&lines, &picture, &status);
        } else if told != status {
            screen.tell(&status);
        }
        if is_last {
            return print("\n");
        }
        if let Some(turn) = &mut turn {
            turn.go_on(feed);
        }
    }
}

/// The view, which turns slowly.
struct Turn {
    views: Vec<View>,
    begun: Instant,
    next: Instant,
}

impl Turn {
    fn new(start: &View) -> Self {
        let now = Instant::now();
        Self { views: start.orbit(VIEWS), begun: now, next: now }
    }

    /// Wishes for the view of this moment, as large as the terminal.
    fn go_on(&mut self, feed: &Feed) {
        let now = Instant::now();
        if now < self.next {
            return;
        }
        self.next = now + VIEW;
        let at = self.begun.elapsed().as_millis() / VIEW.as_millis();
        let view = self.views[at as usize % self.views.len()];
        let [columns, rows] = room();
        let size = fit(view.size(), [columns, rows.saturating_sub(1).max(1)]);
        let wish = Wish { view, mode: Mode::Colour, quality: QUALITY, fps: 30.0, size };
        feed.change(|state| match &mut state.wish {
            // The last picture shows the finished model from where the view is.
            Some(before) if state.finished => before.size = size,
            before => *before = Some(wish),
        });
    }
}

/// What was printed last.
#[derive(Default)]
struct Screen {
    /// Rows above the line with the cursor.
    rows: usize,
}

impl Screen {
    /// Prints lines, and below them a picture and the status in place of those before.
    fn draw(&mut self, lines: &[String], picture: &Picture, status: &str) {
        let mut out = String::from("\r");
        if self.rows > 0 {
            // Writing to a string cannot fail.
            let _ = write!(out, "\x1b[{}A", self.rows);
        }
        if !lines.is_empty() {
            out.push_str("\x1b[J");
        }
        for line in lines {
            let _ = writeln!(out, "{line}");
        }
        let picture = text(picture);
        for row in picture.lines() {
            let _ = writeln!(out, "{row}\x1b[K");
        }
        let rows = picture.lines().count();
        if rows < self.rows {
            out.push_str("\x1b[J");
        }
        self.rows = rows;
        print(&out);
        self.tell(status);
    }

    /// Prints the status in place of the one before.
    fn tell(&self, status: &str) {
        let columns = room()[0] as usize;
        let status: String = status.chars().take(columns.saturating_sub(1)).collect();
        print(&format!("\r{status}\x1b[K"));
    }
}

/// It is no error if nobody reads it.
fn print(text: &str) {
    let _ = stderr().write_all(text.as_bytes()).and_then(|()| stderr().flush());
}
