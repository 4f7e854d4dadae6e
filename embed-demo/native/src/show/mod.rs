//! What a window shows: a small picture at once while something moves, and the complete
//! one, tile by tile, at rest. Independent of any window system.

mod figures;
pub mod pace;

use std::time::{Duration, Instant};

use pocketnerf_core::Error;
use pocketnerf_core::render::{RenderStats, Tiles};

use crate::paint::modes::Mode;
use crate::paint::picture::Picture;
use crate::paint::{Painter, Shot};
use crate::view::View;

pub use figures::Figures;
use pace::Pace;

/// Rest after which the complete picture starts: longer than the time between two events of
/// a moving hand.
const SETTLES: Duration = Duration::from_millis(60);
/// How long tiles are rendered before events are handled.
const BATCH: Duration = Duration::from_millis(15);
/// Quality of moving pictures: in the same time, more pixels of lower quality are closer to
/// the complete picture (docs/window.md).
pub(crate) const MOVING_QUALITY: f32 = 0.0;

/// The next thing to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Work, as soon as no event is pending.
    Now,
    /// Nothing before this time.
    At(Instant),
    /// Nothing: the picture is complete.
    Rest,
}

/// Progress of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Work {
    /// Something has changed: render a picture small enough to be in time.
    Move,
    /// The small picture is shown; the complete one starts then.
    Settle(Instant),
    /// This many tiles of the complete picture are rendered.
    Refine(u32),
    /// The picture is complete.
    Rest,
}

/// The state of what is shown.
#[derive(Debug)]
pub struct Show<'m> {
    painter: Painter<'m>,
    /// The view.
    pub view: View,
    /// What is shown.
    pub mode: Mode,
    /// Quality at rest.
    pub quality: f32,
    /// Chooses the size of moving pictures.
    pub pace: Pace,
    /// Timings.
    pub figures: Figures,
    work: Work,
    changed: Instant,
    /// When the last moving picture was started, and how long it took to paint.
    frame: (Instant, Duration),
    /// The picture that is shown, as large as the window.
    shown: Picture,
    small: Picture,
    /// The moving picture of the same camera, to compare with the complete one.
    moving: Picture,
    /// Seconds for a tile, with all threads at work.
    tile: f64,
}

impl<'m> Show<'m> {
    /// Shows nothing until [`resize`](Self::resize).
    #[must_use]
    pub fn new(painter: Painter<'m>, view: View, mode: Mode, quality: f32, fps: f64) -> Self {
        let now = Instant::now();
        Self {
            painter,
            view,
            mode,
            quality,
            pace: Pace::new(fps),
            figures: Figures::default(),
            work: Work::Rest,
            changed: now,
            frame: (now, Duration::ZERO),
            shown: Picture::default(),
            small: Picture::default(),
            moving: Picture::default(),
            tile: 0.0,
        }
    }

    /// The painter.
    #[must_use]
    pub const fn painter(&self) -> &Painter<'m> {
        &self.painter
    }

    /// The picture that is shown.
    #[must_use]
    pub const fn shown(&self) -> &Picture {
        &self.shown
    }

    /// Whether the picture is complete.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.work == Work::Rest
    }

    /// Sets the size of the window.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        if [self.shown.width, self.shown.height] != [width, height] {
            self.shown = Picture::new(width, height);
            self.change();
        }
    }

    /// Starts a new picture, because something has changed.
    pub fn change(&mut self) {
        self.changed = Instant::now();
        self.work = Work::Move;
    }

    /// The complete picture as it is now.
    #[must_use]
    pub fn shot(&self) -> Shot {
        let camera = self.view.camera(self.shown.width, self.shown.height);
        Shot { camera, mode: self.mode, quality: self.quality }
    }

    /// The complete picture: the one that is shown, if it is complete.
    ///
    /// # Errors
    /// Those of [`Painter::paint`].
    pub fn whole(&self) -> Result<Picture, Error> {
        match self.is_at_rest() {
            true => Ok(self.shown.clone()),
            false => Ok(self.painter.picture(&self.shot())?.0),
        }
    }

    /// The next thing to do.
    #[must_use]
    pub fn next(&self) -> Next {
        match self.work {
            // A minimised window.
            _ if self.shown.pixels.is_empty() => Next::Rest,
            Work::Settle(until) if until > Instant::now() => Next::At(until),
            Work::Rest => Next::Rest,
            _ => Next::Now,
        }
    }

    /// Does a piece of work, short enough for a frame, if there is any now; returns whether
    /// it was a moving picture.
    ///
    /// # Errors
    /// Those of [`Painter::paint`].
    pub fn work(&mut self) -> Result<bool, Error> {
        match (self.next(), self.work) {
            (Next::Now, Work::Move) => return self.paint_moving().map(|()| true),
            (Next::Now, Work::Refine(done)) => self.refine(done)?,
            (Next::Now, _) => self.refine(0)?,
            _ => {}
        }
        Ok(false)
    }

    /// To be called when a moving picture is on the screen.
    pub fn presented(&mut self) {
        let (begun, painting) = self.frame;
        let all = begun.elapsed();
        self.pace.shown(all.saturating_sub(painting).as_secs_f64());
        self.figures.shown(all);
    }

    /// Renders a picture that is in time.
    fn paint_moving(&mut self) -> Result<(), Error> {
        let begun = Instant::now();
        let window = [self.shown.width, self.shown.height];
        let [width, height] = self.pace.size(window);
        let mut shot = self.shot();
        shot.quality = shot.quality.min(MOVING_QUALITY);
        let is_whole = [width, height] == window && shot.quality == self.quality;
        let shot = shot.sized([width, height]);
        if [self.small.width, self.small.height] != [width, height] {
            self.small = Picture::new(width, height);
        }
        let tiles = Tiles::new(width, height);
        let stats = self.painter.paint(&shot, tiles, &mut self.small)?;
        let took = begun.elapsed();
        let pixels = |[w, h]: [u32; 2]| f64::from(w) * f64::from(h);
        self.pace.rendered(pixels([width, height]), pixels(window), took.as_secs_f64());
        let (painter, small, shown) = (&self.painter, &self.small, &mut self.shown);
        painter.install(|| small.enlarge(shown));
        self.figures.painted(stats, f64::from(width) / f64::from(window[0]), shot.quality);
        self.frame = (begun, took);
        self.work = match is_whole {
            true => Work::Rest,
            false => Work::Settle(self.changed + SETTLES),
        };
        if is_whole {
            self.figures.rested(self.changed.elapsed(), None);
        }
        Ok(())
    }

    /// Renders more tiles of the complete picture.
    fn refine(&mut self, mut done: u32) -> Result<(), Error> {
        if done == 0 {
            self.moving.clone_from(&self.shown);
            self.figures.painted(RenderStats::default(), 1.0, self.quality);
            self.figures.paused();
        }
        let (begun, shot) = (Instant::now(), self.shot());
        let tiles = Tiles::new(self.shown.width, self.shown.height);
        let threads = self.painter.threads();
        // The cost of the first tiles is unknown; each thread renders one.
        let fit = (BATCH.as_secs_f64() / self.tile.max(1e-6)) as usize;
        let batch = if done == 0 { threads } else { fit.next_multiple_of(threads).max(threads) };
        let some = tiles.clone().skip(done as usize).take(batch);
        let n = some.clone().count() as u32;
        let stats = self.painter.paint(&shot, some, &mut self.shown)?;
        self.tile = begun.elapsed().as_secs_f64() / f64::from(n.max(1));
        self.figures.add(stats);
        done += n;
        self.work = Work::Refine(done);
        if done as usize >= tiles.count() {
            let (painter, shown, moving) = (&self.painter, &self.shown, &self.moving);
            let psnr = painter.install(|| moving.psnr(shown));
            self.figures.rested(self.changed.elapsed(), psnr);
            self.work = Work::Rest;
        }
        Ok(())
    }
}
