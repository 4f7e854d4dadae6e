//! Timings of pictures, for the overlay and for scripts.

use std::time::{Duration, Instant};

use pocketnerf_core::render::RenderStats;

/// Timings of pictures.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Milliseconds for the last moving picture, until it was on the screen.
    pub frame_ms: f64,
    /// Moving pictures shown per second, over about the last ten.
    pub fps: f64,
    /// Width of the rendered picture, as a fraction of the window's.
    pub scale: f64,
    /// Quality of the picture.
    pub quality: f32,
    /// Rays and samples of the picture.
    pub stats: RenderStats,
    /// Milliseconds from the last change to the complete picture.
    pub rest_ms: f64,
    /// PSNR of the last moving picture against the complete one of the same camera, dB.
    pub moving_psnr: Option<f32>,
    /// When a moving picture was last shown.
    last: Option<Instant>,
    /// Everything so far, if a script plays.
    log: Option<Log>,
}

/// Everything so far.
#[derive(Clone, Debug, Default)]
struct Log {
    /// Time from a moving picture to the next, ms.
    frames: Vec<f64>,
    scales: Vec<f64>,
    rests: Vec<f64>,
    psnrs: Vec<f64>,
}

impl Figures {
    /// Keeps all timings from now on.
    pub fn keep(&mut self) {
        self.log = Some(Log::default());
    }

    /// A picture was painted, or the first tiles of one.
    pub(crate) fn painted(&mut self, stats: RenderStats, scale: f64, quality: f32) {
        (self.stats, self.scale, self.quality) = (stats, scale, quality);
    }

    /// More tiles of the same picture.
    pub(crate) fn add(&mut self, stats: RenderStats) {
        self.stats += stats;
    }

    /// A moving picture is on the screen; `took` since it was started.
    pub(crate) fn shown(&mut self, took: Duration) {
        self.frame_ms = 1e3 * took.as_secs_f64();
        let now = Instant::now();
        let since = self.last.replace(now).map(|last| now - last);
        let Some(seconds) = since.map(|since| since.as_secs_f64()) else { return };
        let before = if self.fps > 0.0 { 1.0 / self.fps } else { seconds };
        self.fps = 1.0 / (before + 0.1 * (seconds - before));
        if let Some(log) = &mut self.log {
            log.frames.push(1e3 * seconds);
            log.scales.push(self.scale);
        }
    }

    /// The next moving picture belongs to another movement.
    pub(crate) fn paused(&mut self) {
        self.last = None;
    }

    /// The picture is complete; `after` since the last change.
    pub(crate) fn rested(&mut self, after: Duration, psnr: Option<f32>) {
        self.rest_ms = 1e3 * after.as_secs_f64();
        self.moving_psnr = psnr;
        if let Some(log) = &mut self.log {
            log.rests.push(self.rest_ms);
            log.psnrs.extend(psnr.map(f64::from));
        }
    }

    /// All timings that were kept, as one line of JSON.
    #[must_use]
    pub fn json(&self) -> String {
        let log = self.log.clone().unwrap_or_default();
        let number = |v: Option<f64>| v.map_or_else(|| "null".to_owned(), |v| format!("{v:.2}"));
        let at = |values: &[f64], part| number(quantile(values, part));
        let fps = quantile(&log.frames, 0.5).map(|ms| 1e3 / ms);
        format!(
            "{{\"frames\":{},\"fps\":{},\"frame_ms\":{},\"frame_ms_p95\":{},\"frame_ms_max\":{},\
             \"scale\":{},\"rests\":{},\"rest_ms\":{},\"rest_ms_max\":{},\"moving_psnr\":{}}}",
            log.frames.len(),
            number(fps),
            at(&log.frames, 0.5),
            at(&log.frames, 0.95),
            at(&log.frames, 1.0),
            at(&log.scales, 0.5),
            log.rests.len(),
            number(log.rests.last().copied()),
            at(&log.rests, 1.0),
            number(log.psnrs.last().copied()),
        )
    }
}

/// The quantile of `values` at `part`, from 0 to 1.
fn quantile(values: &[f64], part: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    sorted.get((part * last as f64).round() as usize).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_by_hand() {
        let values: Vec<f64> = (0..=20).rev().map(f64::from).collect();
        assert_eq!(quantile(&values, 0.5), Some(10.0));
        assert_eq!(quantile(&values, 0.95), Some(19.0));
        assert_eq!(quantile(&values, 1.0), Some(20.0));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn nothing_is_null() {
        let json = Figures::default().json();
        assert!(json.starts_with("{\"frames\":0,\"fps\":null,") && json.ends_with("null}"));
    }
}
