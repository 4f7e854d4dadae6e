//! What a window shows: a small picture at once while things move, and the whole one, tile
//! by tile, when they rest. Knows no window.

use std::time::{Duration, Instant};

use pocketnerf_core::Error;
use pocketnerf_core::render::{RenderStats, Tiles};

use crate::figures::Figures;
use crate::modes::Mode;
use crate::pace::Pace;
use crate::painter::{Painter, Shot};
use crate::picture::Picture;
use crate::view::View;

/// Stillness after which the whole picture is begun: longer than between two events of a
/// hand that moves.
const SETTLES: Duration = Duration::from_millis(60);
/// How long tiles are rendered before events are looked for.
const BATCH: Duration = Duration::from_millis(15);
/// Quality of moving pictures: at equal time, more pixels in less quality come nearer to the
/// whole picture (docs/window.md).
const MOVING_QUALITY: f32 = 0.0;

/// What is to be done next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Work, as soon as no event waits.
    Now,
    /// Nothing before this time.
    At(Instant),
    /// Nothing: the picture is whole.
    Rest,
}

/// Where the work stands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Work {
    /// Something has changed: a new picture, small enough to be there in time.
    Move,
    /// Such a picture is there; the whole one may begin.
    Settle(Instant),
    /// So many tiles of the whole one are there.
    Refine(u32),
    /// The picture is whole.
    Rest,
}

/// What is shown, how, and how far it is.
#[derive(Debug)]
pub struct Show<'m> {
    painter: Painter<'m>,
    /// From where.
    pub view: View,
    /// What of.
    pub mode: Mode,
    /// Quality at rest.
    pub quality: f32,
    /// Chooses the size of moving pictures.
    pub pace: Pace,
    /// What it takes.
    pub figures: Figures,
    work: Work,
    changed: Instant,
    /// When the last moving picture was begun, and how long it was painted.
    frame: (Instant, Duration),
    /// The picture that is shown, as large as the window.
    shown: Picture,
    small: Picture,
    /// The moving picture of the same camera, to compare the whole one with.
    moving: Picture,
    /// Seconds that a tile takes, all threads at work.
    tile: f64,
}

impl<'m> Show<'m> {
    /// Nothing yet: [`resize`](Self::resize) begins.
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

    /// Who paints.
    #[must_use]
    pub const fn painter(&self) -> &Painter<'m> {
        &self.painter
    }

    /// The picture that is shown.
    #[must_use]
    pub const fn shown(&self) -> &Picture {
        &self.shown
    }

    /// Whether the picture is whole.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.work == Work::Rest
    }

    /// The window has another size.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        if [self.shown.width, self.shown.height] != [width, height] {
            self.shown = Picture::new(width, height);
            self.change();
        }
    }

    /// Something that the picture shows has changed.
    pub fn change(&mut self) {
        self.changed = Instant::now();
        self.work = Work::Move;
    }

    /// What the picture of this moment is, in full.
    #[must_use]
    pub fn shot(&self) -> Shot {
        let camera = self.view.camera(self.shown.width, self.shown.height);
        Shot { camera, mode: self.mode, quality: self.quality }
    }

    /// The whole picture: the one that is shown, where it is whole.
    ///
    /// # Errors
    /// Those of [`Painter::paint`].
    pub fn whole(&self) -> Result<Picture, Error> {
        match self.is_at_rest() {
            true => Ok(self.shown.clone()),
            false => Ok(self.painter.picture(&self.shot())?.0),
        }
    }

    /// What is to be done next.
    #[must_use]
    pub fn next(&self) -> Next {
        match self.work {
            // A minimised window: until it has a size again there is nothing to do.
            _ if self.shown.pixels.is_empty() => Next::Rest,
            Work::Settle(until) if until > Instant::now() => Next::At(until),
            Work::Rest => Next::Rest,
            _ => Next::Now,
        }
    }

    /// Does a piece of work, short enough for a frame, if there is any now; says whether
    /// it is a moving picture.
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

    /// A moving picture is on the screen.
    pub fn presented(&mut self) {
        let (begun, painting) = self.frame;
        let all = begun.elapsed();
        self.pace.shown(all.saturating_sub(painting).as_secs_f64());
        self.figures.shown(all);
    }

    /// A picture that is there in time.
    fn paint_moving(&mut self) -> Result<(), Error> {
        let begun = Instant::now();
        let window = [self.shown.width, self.shown.height];
        let [width, height] = self.pace.size(window);
        let mut shot = self.shot();
        shot.quality = shot.quality.min(MOVING_QUALITY);
        let is_whole = [width, height] == window && shot.quality == self.quality;
        let [across, down] = [width as f32 / window[0] as f32, height as f32 / window[1] as f32];
        let camera = &mut shot.camera;
        (camera.width, camera.height) = (width, height);
        camera.focal = [camera.focal[0] * across, camera.focal[1] * down];
        camera.center = [camera.center[0] * across, camera.center[1] * down];
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

    /// Some more tiles of the whole picture.
    fn refine(&mut self, mut done: u32) -> Result<(), Error> {
        if done == 0 {
            self.moving.clone_from(&self.shown);
            self.figures.painted(RenderStats::default(), 1.0, self.quality);
            self.figures.paused();
        }
        let (begun, shot) = (Instant::now(), self.shot());
        let tiles = Tiles::new(self.shown.width, self.shown.height);
        let threads = self.painter.threads();
        // Of the first tiles nothing is known; each thread should have one.
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
