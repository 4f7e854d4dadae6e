//! How much of the processor's time painting may take from whoever learns the model.

use std::time::{Duration, Instant};

/// Share of the time of all cores that painting may take.
pub const SHARE: f64 = 0.05;
/// Time that was not used stays for so long: a hand that begins to move is followed at once.
const CREDIT: Duration = Duration::from_secs(1);

/// Keeps work to a share of the processor's time: after work of c core-seconds there is a pause
/// until c / share has passed. Reads no clock itself.
#[derive(Clone, Copy, Debug)]
pub struct Governor {
    /// Core-seconds a second, at most one core's.
    rate: f64,
    free: Instant,
}

impl Governor {
    /// For a [`SHARE`] of so many cores.
    #[must_use]
    pub fn new(cores: usize, now: Instant) -> Self {
        Self { rate: (SHARE * cores as f64).min(1.0), free: now }
    }

    /// Core-seconds that a second may have.
    #[must_use]
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// Counts work that is done.
    pub fn spend(&mut self, core_seconds: f64, now: Instant) {
        let from = now.checked_sub(CREDIT).map_or(self.free, |kept| self.free.max(kept));
        let pause = Duration::try_from_secs_f64(core_seconds / self.rate);
        // A pause without an end is one of an hour.
        self.free = from + pause.unwrap_or(Duration::from_secs(3600));
    }

    /// When the next work may begin.
    #[must_use]
    pub const fn free(&self) -> Instant {
        self.free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn work_takes_its_share_and_no_more() {
        let begun = Instant::now();
        let mut governor = Governor::new(2, begun);
        assert!((governor.rate() - 0.1).abs() < 1e-12);
        // Frames of 12 ms, as often as they may be, and a long one now and then.
        let (mut now, mut worked) = (begun, 0.0);
        for frame in 0..1000 {
            now = now.max(governor.free());
            let cost = if frame % 50 == 0 { 0.3 } else { 0.012 };
            now += Duration::from_secs_f64(cost);
            governor.spend(cost, now);
            worked += cost;
        }
        let share = worked / (governor.free() - begun).as_secs_f64();
        assert!((share - 0.1).abs() < 0.001, "{share}");
    }

    #[test]
    fn unused_time_is_kept_for_a_second() {
        let begun = Instant::now();
        let mut governor = Governor::new(4, begun);
        let later = begun + 60_000 * MS;
        governor.spend(0.1, later);
        assert_eq!(governor.free(), later - 500 * MS);
        governor.spend(0.2, later);
        assert_eq!(governor.free(), later + 500 * MS);
    }

    #[test]
    fn one_thread_paints_at_most() {
        assert_eq!(Governor::new(128, Instant::now()).rate(), 1.0);
    }
}
