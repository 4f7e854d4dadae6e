//! How much of a picture is rendered at a time.

use std::time::Duration;

/// Systems reset a GPU that does not answer for seconds, and a desktop stutters much earlier.
const MOST_TIME: Duration = Duration::from_millis(40);
/// Rows of a workgroup.
const ROWS: u32 = 8;

/// Pixels that a GPU is asked for at a time: as many as it renders in a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bands {
    pixels: u32,
    most: u32,
}

impl Bands {
    /// So little that a slow GPU renders the slowest model in time; never more than `most` pixels.
    pub(super) fn new(most: u32) -> Self {
        Self { pixels: (1 << 9).min(most), most }
    }

    /// Whole rows of the next band of a picture of this width, `left` of which are left.
    pub(super) fn rows(&self, width: u32, left: u32) -> u32 {
        let rows = (self.pixels / width.max(1)).max(1).next_multiple_of(ROWS);
        // Not one row more than there is memory for.
        rows.min(left).min((self.most / width.max(1)).max(1))
    }

    /// Takes note of how long a band took.
    pub(super) fn took(&mut self, pixels: u32, time: Duration) {
        let times = MOST_TIME.as_secs_f64() / time.as_secs_f64().max(1e-6);
        // Halfway, because pixels differ; and no more than four times as much at once.
        let next = f64::from(pixels) * (0.5 + 0.5 * times).clamp(0.1, 4.0);
        // A band at the end of a picture is small and says little of what fits.
        if times < 1.0 || pixels >= self.pixels / 2 {
            self.pixels = (next as u32).clamp(1, self.most);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_follow_the_time() {
        let mut bands = Bands::new(1 << 20);
        assert_eq!((bands.rows(20, 1000), bands.rows(20, 20)), (32, 20));
        assert_eq!(bands.rows(9999, 1000), 8);
        // Ten times as fast as it need be: four times as many, then as many as there may be.
        bands.took(4000, Duration::from_millis(4));
        assert_eq!(bands.pixels, 16_000);
        for _ in 0..9 {
            bands.took(bands.pixels, Duration::from_millis(1));
        }
        assert_eq!((bands.pixels, bands.rows(4096, 9999)), (1 << 20, 256));
        // Twice as slow: three quarters. A rest that was quick changes nothing.
        bands.took(1 << 20, Duration::from_millis(80));
        assert_eq!(bands.pixels, 3 << 18);
        bands.took(100, Duration::from_millis(1));
        assert_eq!(bands.pixels, 3 << 18);
        // However slow, and however wide: one row of workgroups.
        (0..99).for_each(|_| bands.took(bands.pixels, Duration::from_secs(9)));
        assert_eq!((bands.pixels, bands.rows(16_384, 100)), (1, 8));
        assert_eq!(Bands::new(1000).rows(900, 100), 1);
    }
}
