//! The window on a model that is still learnt.

use std::time::{Duration, Instant};

use pocketnerf_core::Error;

use super::feed::{Feed, Wish};
use super::painting::Painting;
use crate::Failure;
use crate::paint::modes::Mode;
use crate::paint::picture::Picture;
use crate::show::{Figures, Next};
use crate::view::View;
use crate::window::input::Input;
use crate::window::{Content, Desktop, KEYS, Settings};

/// When the window looks again by itself; whatever changes wakes it.
const LATER: Duration = Duration::from_secs(3600);
/// Pictures a second of the finished model while something moves.
const FPS: f64 = 30.0;
/// Quality of the complete picture.
const QUALITY: f32 = 0.5;

/// What the window shows of a feed.
struct Live<'f> {
    feed: &'f Feed,
    wish: Wish,
    shown: Picture,
    /// Whether the picture is complete, and the one that was wished for.
    is_complete: bool,
    /// Whether the model has normals.
    has_normals: bool,
    /// When the picture that is shown was begun.
    begun: Option<Instant>,
    figures: Figures,
}

/// Shows a window until it is closed, or there is nothing more to see; opens it with the first
/// model. The learner has so many `cores`. Gives the timings.
///
/// # Errors
/// One line: what the window system or the renderer reported.
pub fn run(
    feed: &Feed,
    desktop: Desktop,
    cores: usize,
    settings: Settings,
) -> Result<Figures, Failure> {
    let look = |bytes: &[u8]| {
        let bytes = pocketnerf_formats::unpacked(bytes)?;
        let file = pocketnerf_formats::open(&bytes)?;
        Ok::<_, Failure>((View::new(&file), file.model.space.scene_box().is_some()))
    };
    let Some(first) = feed.first(look) else { return Ok(Figures::default()) };
    let (view, has_normals) = first?;
    let size = [0; 2];
    let wish = Wish { view, mode: Mode::Colour, quality: QUALITY, fps: FPS, size };
    let shown = Picture::default();
    let figures = Figures::default();
    let live = Live { feed, wish, shown, is_complete: false, has_normals, begun: None, figures };
    let proxy = desktop.proxy();
    let outcome = std::thread::scope(|scope| {
        let painter = scope.spawn(move || {
            // The window may be closed.
            let send = |input| _ = proxy.send_event(input);
            let wake = || send(Input::Painted);
            let painted = Painting::new(feed, cores, &wake).and_then(Painting::run);
            if let Err(why) = painted {
                feed.state().failure = Some(why);
                wake();
            } else {
                send(Input::Quit);
            }
        });
        let outcome = desktop.show(live, settings);
        feed.leave();
        if let Err(panic) = painter.join() {
            std::panic::resume_unwind(panic);
        }
        outcome
    });
    outcome.map(|live| live.figures)
}

impl Content for Live<'_> {
    fn view(&mut self) -> &mut View {
        &mut self.wish.view
    }

    fn mode(&mut self) -> &mut Mode {
        &mut self.wish.mode
    }

    fn quality(&mut self) -> &mut f32 {
        &mut self.wish.quality
    }

    fn fps(&mut self) -> &mut f64 {
        &mut self.wish.fps
    }

    fn shows(&self, mode: Mode) -> bool {
        self.has_normals || mode != Mode::Normals
    }

    fn change(&mut self) {
        self.is_complete = false;
        self.feed.change(|state| state.wish = Some(self.wish));
    }

    fn resize(&mut self, size: [u32; 2]) {
        if self.wish.size != size {
            // What is shown until there is a picture of this size.
            let mut picture = Picture::new(size[0], size[1]);
            self.shown.enlarge(&mut picture);
            (self.wish.size, self.shown) = (size, picture);
            self.change();
        }
    }

    fn next(&self) -> Next {
        if self.is_complete { Next::Rest } else { Next::At(Instant::now() + LATER) }
    }

    fn work(&mut self) -> Result<bool, Failure> {
        let mut state = self.feed.state();
        if let Some(why) = state.failure.take() {
            return Err(why.into());
        }
        let Some(frame) = state.frame.take() else { return Ok(false) };
        drop(state);
        if frame.wish.size == self.wish.size {
            self.is_complete = frame.is_complete && frame.wish == self.wish;
            self.shown = frame.picture;
        }
        self.figures.painted(frame.stats, frame.scale, 0.0);
        self.begun = Some(frame.begun);
        Ok(true)
    }

    fn shown(&self) -> &Picture {
        &self.shown
    }

    fn presented(&mut self, took: Duration) {
        self.feed.state().showing += took.as_secs_f64();
        if let Some(begun) = self.begun.take() {
            self.figures.shown(begun.elapsed());
        }
    }

    fn whole(&self) -> Result<Picture, Error> {
        Ok(self.shown.clone())
    }

    fn figures(&mut self) -> &mut Figures {
        &mut self.figures
    }

    fn progress(&self) -> String {
        self.feed.state().status.clone()
    }

    fn status(&self, name: &str, note: &str) -> String {
        let [width, height] = self.wish.size;
        let (scale, fps) = (self.figures.scale, self.figures.fps);
        let mut lines = vec![format!("{name}, {}, {width}x{height}", self.wish.mode.name())];
        lines.push(self.progress());
        lines.push(format!("scale {scale:.2}, {fps:.1} pictures/s"));
        lines.extend([note, KEYS].map(str::to_owned));
        lines.retain(|line| !line.is_empty());
        lines.join("\n")
    }
}
