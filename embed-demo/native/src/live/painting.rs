//! The thread that paints.

use std::sync::Arc;
use std::time::{Duration, Instant};

use pocketnerf_formats::ModelFile;
use rayon::ThreadPool;

use super::feed::{Feed, Frame, Given, State, Wish};
use super::governor::Governor;
use crate::paint::modes::Mode;
use crate::paint::picture::Picture;
use crate::paint::{Painter, Shot};
use crate::show::pace::Pace;
use crate::show::{MOVING_QUALITY, Next, Show};
use crate::view::View;

/// Pictures a second while something moves, ...
const MOVING: f64 = 8.0;
/// ... and at rest, if there are so many models: larger pictures, after which a movement need not
/// wait for long.
const RESTING: f64 = 2.0;
/// Time between two pictures at least: small ones in quick succession would use up what larger
/// ones need, and a pause would follow.
const APART: Duration = Duration::from_millis(66);
/// Rest after which a movement is over.
const SETTLES: Duration = Duration::from_millis(300);
/// Time between two models at least.
const BETWEEN: Duration = Duration::from_secs(1);

/// Paints what a feed gives, as its viewer wishes.
pub(super) struct Painting<'f> {
    feed: &'f Feed,
    /// A thread of its own: the learner's have enough to do.
    pool: Arc<ThreadPool>,
    /// All of them, once there is nothing to learn.
    cores: usize,
    governor: Governor,
    pace: Pace,
    /// What was wished for last, and when that changed.
    seen: Option<Wish>,
    moved: Option<Instant>,
    /// When the next picture may begin at the earliest.
    apart: Instant,
    /// Tells the viewer that there is something to see.
    wake: &'f dyn Fn(),
}

impl<'f> Painting<'f> {
    /// Paints beside a learner on so many cores.
    ///
    /// # Errors
    /// One line, if the system refuses a thread.
    pub(super) fn new(feed: &'f Feed, cores: usize, wake: &'f dyn Fn()) -> Result<Self, String> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let pool = Arc::new(pool.map_err(|e| format!("a thread that paints: {e}"))?);
        let apart = Instant::now();
        let governor = Governor::new(cores, apart);
        let pace = Pace::careful(MOVING / governor.rate());
        Ok(Self { feed, pool, cores, governor, pace, seen: None, moved: None, apart, wake })
    }

    /// Paints until nobody looks any more, or there is nothing more to see.
    ///
    /// # Errors
    /// One line: a model that cannot be shown.
    pub(super) fn run(mut self) -> Result<(), String> {
        loop {
            let wanted = |state: &State| state.given.is_some() || state.over;
            let ready = |state: &State| self.feed.is_left() || wanted(state);
            let given = self.feed.wait(None, ready).given.take();
            let Some(given) = given.filter(|_| !self.feed.is_left()) else { return Ok(()) };
            match given.is_final {
                true => self.finished(&given),
                false => self.unfinished(&given),
            }
            .map_err(|e| format!("the model cannot be shown: {e}"))?;
        }
    }

    /// Small pictures of a model, until there is another one.
    fn unfinished(&mut self, given: &Given) -> Result<(), Box<dyn std::error::Error>> {
        // All of the learner's threads waited for it.
        let waited = given.took.as_secs_f64() * self.cores as f64;
        let begun = Instant::now();
        let file = pocketnerf_formats::open(&given.bytes)?;
        let mut table = vec![0; file.model.table_len()];
        let model = file.model.with_table(&mut table)?;
        let painter = Painter::in_pool(&model, Arc::clone(&self.pool));
        self.begin(&file);
        self.governor.spend(waited + begun.elapsed().as_secs_f64(), Instant::now());
        self.notice(self.feed.state().wish);
        let (mut painted, mut since, mut asked) = (None, begun, false);
        loop {
            let (now, free) = (Instant::now(), self.governor.free());
            if asked && !self.feed.is_wanted() {
                // There was none to give.
                (since, asked) = (now, false);
            }
            let asks = (since + BETWEEN).max(free);
            if !asked && painted.is_some() && asks <= now {
                self.feed.want();
                asked = true;
            }
            let settles = self.moved.map(|moved| moved + SETTLES).filter(|settles| now < *settles);
            // What is not shown yet, or only in a smaller picture.
            let wish = self.seen.filter(|wish| wish.size.iter().all(|side| *side > 0));
            let wish = wish.map(|wish| (wish, self.size(&wish, settles.is_some())));
            let due = wish.filter(|(wish, size)| {
                painted.is_none_or(|(before, small): (Wish, [u32; 2])| {
                    before != *wish || small[0] < size[0]
                })
            });
            let paints = free.max(self.apart);
            if let Some((wish, size)) = due.filter(|_| paints <= now) {
                self.apart = now + APART;
                self.paint(&painter, &wish, size)?;
                painted = due;
                continue;
            }
            let asks = (!asked && painted.is_some()).then_some(asks);
            let next = [due.map(|_| paints), settles, asks].into_iter().flatten().min();
            let (seen, feed) = (self.seen, self.feed);
            let is_over = |state: &State| state.given.is_some() || state.over || feed.is_left();
            let state = feed.wait(next, |state| {
                is_over(state) || state.wish != seen || (asked && !feed.is_wanted())
            });
            if is_over(&state) {
                return Ok(());
            }
            let wish = state.wish;
            drop(state);
            self.notice(wish);
        }
    }

    /// The view begins with the first model's own camera.
    fn begin(&self, file: &ModelFile<'_>) {
        self.feed.change(|state| _ = state.start.get_or_insert_with(|| View::new(file)));
    }

    /// Something moves where the wish changes.
    fn notice(&mut self, wish: Option<Wish>) {
        if wish != self.seen {
            self.moved = self.seen.map(|_| Instant::now());
            self.seen = wish;
        }
    }

    /// Width and height that take as long as they may.
    fn size(&mut self, wish: &Wish, is_moving: bool) -> [u32; 2] {
        let fps = if is_moving { MOVING } else { RESTING };
        self.pace.aim(fps / self.governor.rate(), pixels(wish.size));
        self.pace.size(wish.size)
    }

    fn paint(
        &mut self,
        painter: &Painter<'_>,
        wish: &Wish,
        size: [u32; 2],
    ) -> Result<(), pocketnerf_core::Error> {
        let begun = Instant::now();
        let [width, height] = wish.size;
        // A mode that this model does not have is no reason to stop.
        let mode = if painter.shows(wish.mode) { wish.mode } else { Mode::Colour };
        let shot = Shot { camera: wish.view.camera(width, height), mode, quality: MOVING_QUALITY };
        let (small, stats) = painter.picture(&shot.sized(size))?;
        let painting = begun.elapsed();
        self.pace.rendered(pixels(size), pixels(wish.size), painting.as_secs_f64());
        let mut picture = Picture::new(width, height);
        painter.install(|| small.enlarge(&mut picture));
        let all = begun.elapsed();
        let scale = f64::from(size[0]) / f64::from(width);
        let showing =
            self.show(Frame { wish: *wish, picture, scale, is_complete: false, stats, begun });
        self.pace.shown((all - painting).as_secs_f64() + showing);
        self.governor.spend(all.as_secs_f64() + showing, Instant::now());
        Ok(())
    }

    /// Hands a picture over; gives the seconds that showing others took since the last time.
    fn show(&self, frame: Frame) -> f64 {
        let showing = self.feed.change(|state| {
            state.frame = Some(frame);
            std::mem::take(&mut state.showing)
        });
        (self.wake)();
        showing
    }

    /// Pictures of the finished model on all threads, until nobody looks any more.
    fn finished(&self, given: &Given) -> Result<(), Box<dyn std::error::Error>> {
        let bytes = pocketnerf_formats::unpacked(&given.bytes)?;
        let file = pocketnerf_formats::open(&bytes)?;
        let mut table = vec![0; file.model.table_len()];
        let model = file.model.with_table(&mut table)?;
        let is_left = || self.feed.is_left();
        self.begin(&file);
        let begins = self.feed.wait(None, |state| state.wish.is_some() || is_left());
        let Some(mut wish) = begins.wish else { return Ok(()) };
        drop(begins);
        let painter = Painter::new(&model, self.cores)?;
        let mut show = Show::new(painter, wish.view, wish.mode, wish.quality, wish.fps);
        show.resize(wish.size);
        while !is_left() {
            let until = match show.next() {
                Next::Now => {
                    let begun = Instant::now();
                    let moving = show.work()?;
                    let picture = show.shown().clone();
                    let (is_complete, stats) = (show.is_at_rest(), show.figures.stats);
                    let scale = if moving { show.pace.scale() } else { 1.0 };
                    self.show(Frame { wish, picture, scale, is_complete, stats, begun });
                    if moving {
                        show.presented();
                    }
                    Some(begun)
                }
                Next::At(time) => Some(time),
                Next::Rest => None,
            };
            let changed = |state: &State| is_left() || state.wish != Some(wish);
            let state = self.feed.wait(until, changed);
            let Some(new) = state.wish.filter(|new| *new != wish) else { continue };
            drop(state);
            wish = new;
            (show.view, show.mode, show.quality) = (wish.view, wish.mode, wish.quality);
            show.pace.fps = wish.fps;
            show.resize(wish.size);
            show.change();
        }
        Ok(())
    }
}

fn pixels([width, height]: [u32; 2]) -> f64 {
    f64::from(width) * f64::from(height)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STILL_LIFE: &[u8] = include_bytes!("../../../still-life.pnerf");
    const GOLDEN: &[u8] = include_bytes!("../../../../tests/golden/hash-grid-f16.pnerf");

    /// The next picture.
    fn frame(feed: &Feed) -> Frame {
        let state = &mut *feed.wait(None, |state| state.frame.is_some());
        state.frame.take().unwrap()
    }

    /// Waits until another model is wanted.
    fn wanted(feed: &Feed) {
        while !feed.is_wanted() {
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// The complete picture of a file.
    fn whole(bytes: &[u8], wish: &Wish) -> Picture {
        let file = pocketnerf_formats::open(bytes).unwrap();
        let camera = wish.view.camera(wish.size[0], wish.size[1]);
        let shot = Shot { camera, mode: wish.mode, quality: wish.quality };
        Painter::new(&file.model, 1).unwrap().picture(&shot).unwrap().0
    }

    #[test]
    fn every_model_is_shown_and_the_last_one_complete() {
        let feed = Feed::default();
        let painter = {
            let feed = feed.clone();
            std::thread::spawn(move || Painting::new(&feed, 64, &|| ()).unwrap().run())
        };
        feed.give(Some(STILL_LIFE.to_vec()), Duration::ZERO);
        let view = feed.wait(None, |state| state.start.is_some()).start.unwrap();
        assert_eq!(view, View::new(&pocketnerf_formats::open(STILL_LIFE).unwrap()));
        let size = [48, 32];
        let wish = Wish { view, mode: Mode::Colour, quality: 0.5, fps: 30.0, size };
        feed.change(|state| state.wish = Some(wish));
        // The first one is as small as can be, as nothing is known of what a pixel takes.
        let first = frame(&feed);
        assert_eq!([first.picture.width, first.picture.height], size);
        assert!(first.wish == wish && first.scale < 0.1 && !first.is_complete);
        wanted(&feed);
        // What cannot be given is asked for again.
        feed.give(None, Duration::ZERO);
        wanted(&feed);
        let mut turned = wish;
        turned.view.turn(0.7, 0.0);
        feed.change(|state| state.wish = Some(turned));
        while frame(&feed).wish != turned {}
        // Packed, as training writes it.
        feed.finish(pocketnerf_formats::pack(GOLDEN).unwrap());
        let last = loop {
            let frame = frame(&feed);
            if frame.is_complete {
                break frame;
            }
        };
        assert!(last.wish == turned && last.picture == whole(GOLDEN, &turned));
        feed.change(|state| state.wish = Some(wish));
        while !frame(&feed).is_complete {}
        feed.leave();
        assert_eq!(painter.join().unwrap(), Ok(()));
    }

    #[test]
    fn what_is_no_model_is_told_in_a_line() {
        let feed = Feed::default();
        feed.give(Some(vec![1, 2, 3]), Duration::ZERO);
        let why = Painting::new(&feed, 1, &|| ()).unwrap().run().unwrap_err();
        assert!(why.starts_with("the model cannot be shown: not a .pnerf file"), "{why}");
        feed.end();
        assert_eq!(Painting::new(&feed, 1, &|| ()).unwrap().run(), Ok(()));
    }
}
