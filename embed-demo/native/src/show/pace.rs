//! The size of moving pictures that holds a frame rate.

/// Fraction of a frame's time that is planned for; the rest absorbs variation.
const PLANNED: f64 = 0.85;
/// Scales are multiples of this, so the picture does not flicker between sizes.
const STEP: f64 = 1.0 / 32.0;
/// Weight of the last frame against those before.
const NEWEST: f64 = 0.3;

/// Chooses scales from the measured cost of frames. Reads no clock itself.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Target frames per second.
    pub fps: f64,
    /// Seconds per rendered pixel; `None` before the first.
    pixel: Option<f64>,
    /// Seconds for the rest of a frame: enlarging, showing.
    rest: f64,
    scale: f64,
}

impl Pace {
    /// For a frame rate; starts with a small picture, because its cost is unknown.
    #[must_use]
    pub const fn new(fps: f64) -> Self {
        Self { fps, pixel: None, rest: 0.0, scale: 0.25 }
    }

    /// The same, with the smallest picture, where a pixel may take long.
    #[must_use]
    pub const fn careful(fps: f64) -> Self {
        Self { scale: STEP, ..Self::new(fps) }
    }

    /// Fraction of the window's width and height to render, at most 1.
    #[must_use]
    pub const fn scale(&self) -> f64 {
        self.scale
    }

    /// Width and height to render for a window of this size.
    #[must_use]
    pub fn size(&self, window: [u32; 2]) -> [u32; 2] {
        window.map(|side| ((f64::from(side) * self.scale).round() as u32).max(1))
    }

    /// Chooses the next scale: rendering `pixels` for a window with `window` pixels took
    /// `seconds`.
    pub fn rendered(&mut self, pixels: f64, window: f64, seconds: f64) {
        if pixels <= 0.0 || window <= 0.0 {
            return;
        }
        let now = seconds / pixels;
        // Twice the cost is a different place, not noise.
        let known = self.pixel.filter(|known| now < 2.0 * known);
        self.pixel = Some(known.map_or(now, |known| known + NEWEST * (now - known)));
        self.choose(window);
    }

    /// Another frame rate, for a window with `window` pixels.
    pub fn aim(&mut self, fps: f64, window: f64) {
        if fps != self.fps {
            self.fps = fps;
            self.choose(window);
        }
    }

    fn choose(&mut self, window: f64) {
        let Some(pixel) = self.pixel else { return };
        let budget = (PLANNED / self.fps - self.rest).max(0.1 / self.fps);
        let wanted = (budget / (pixel.max(1e-12) * window)).sqrt();
        let stepped = (wanted / STEP).floor() * STEP;
        // One step up only if it is well within reach, or the scale would oscillate.
        let is_near = stepped > self.scale && wanted < self.scale + 1.5 * STEP;
        if !is_near {
            self.scale = stepped.clamp(STEP, 1.0);
        }
    }

    /// Adds the seconds that the rest of a frame took.
    pub fn shown(&mut self, seconds: f64) {
        self.rest += NEWEST * (seconds - self.rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: f64 = 640_000.0;

    /// Frames of a machine that takes so long for a pixel, and a little for each frame.
    fn run(pace: &mut Pace, seconds_per_pixel: f64, frames: usize) -> Vec<f64> {
        let frame = |_| {
            let [w, h] = pace.size([800, 800]).map(f64::from);
            let seconds = 1e-3 + w * h * seconds_per_pixel;
            pace.rendered(w * h, WINDOW, seconds);
            pace.shown(2e-3);
            seconds + 2e-3
        };
        (0..frames).map(frame).collect()
    }

    #[test]
    fn holds_its_rate() {
        for fps in [15.0, 30.0, 60.0] {
            let mut pace = Pace::new(fps);
            let frames = run(&mut pace, 150e-9, 50);
            let late = &frames[10..];
            assert!(late.iter().all(|s| *s < 1.0 / fps), "{fps}: {late:?}");
            assert!(late.iter().all(|s| *s > 0.5 / fps), "{fps}: {late:?}");
            let scale = pace.scale();
            run(&mut pace, 150e-9, 50);
            assert_eq!(pace.scale(), scale);
        }
    }

    #[test]
    fn a_fast_machine_renders_everything() {
        let mut pace = Pace::new(30.0);
        run(&mut pace, 10e-9, 10);
        assert_eq!(pace.scale(), 1.0);
        assert_eq!(pace.size([801, 3]), [801, 3]);
    }

    #[test]
    fn what_suddenly_costs_more_is_noticed_at_once() {
        let mut pace = Pace::new(30.0);
        run(&mut pace, 100e-9, 30);
        let frames = run(&mut pace, 1000e-9, 4);
        assert!(frames[0] > 1.0 / 30.0 && frames[1] < 1.0 / 30.0, "{frames:?}");
    }

    #[test]
    fn another_rate_is_another_size_at_once() {
        let mut pace = Pace::careful(60.0);
        assert_eq!(pace.size([800, 800]), [25, 25]);
        run(&mut pace, 150e-9, 20);
        let small = pace.scale();
        pace.aim(15.0, WINDOW);
        assert!(pace.scale() > 1.5 * small, "{small}");
        let frame = run(&mut pace, 150e-9, 1)[0];
        assert!((0.5 / 15.0..1.0 / 15.0).contains(&frame), "{frame}");
        pace.aim(60.0, WINDOW);
        assert_eq!(pace.scale(), small);
    }

    #[test]
    fn the_slowest_machine_still_renders_something() {
        let mut pace = Pace::new(60.0);
        run(&mut pace, 1.0, 3);
        assert_eq!(pace.scale(), STEP);
        assert_eq!(pace.size([3, 800]), [1, 25]);
        pace.rendered(0.0, 0.0, 1.0);
    }
}
