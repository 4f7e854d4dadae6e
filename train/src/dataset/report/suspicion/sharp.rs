//! Photographs that are blurred beside the others.
//!
//! How much detail there is depends on what is shown. Blur takes it from the finest scale first:
//! differences of neighbouring pixels become small beside those of pixels twice as wide.

use super::photo::{Luma, Photo};
use super::{Suspect, Suspicion};
use crate::metrics::median;

/// A photograph is blurred below this part of the usual sharpness: of lego, fern, fox and tumbler,
/// the least has 0.84 ...
const BLURRED: f64 = 0.6;
/// ... and if it lacks so many times as much as photographs differ by.
const TIMES: f64 = 3.5;
/// Fewer places where all around counts say nothing.
const FEWEST: usize = 100;

pub(super) fn find(suspect: &Suspect<'_, '_>, photos: &[Option<Photo>]) -> Option<Suspicion> {
    let all = photos.iter().enumerate();
    let sharp: Vec<(usize, f64)> =
        all.filter_map(|(i, photo)| Some((i, photo.as_ref()?.sharpness?))).collect();
    let usual = median(sharp.iter().map(|(_, sharpness)| *sharpness))?;
    // Where surfaces are smooth, it depends on what is seen.
    let differs = median(sharp.iter().map(|(_, s)| (s / usual - 1.0).abs()))?;
    let least = usual * BLURRED.min(1.0 - TIMES * differs);
    let which: Vec<usize> = sharp.iter().filter(|(_, s)| *s < least).map(|(i, _)| *i).collect();
    (!which.is_empty()).then(|| {
        Suspicion::new(
            "blurred",
            format!(
                "{}; take the frames out, or take them again",
                suspect.some("photographs that are blurred beside the others", &which)
            ),
        )
    })
}

/// The mean second difference of single pixels, divided by that of blocks of 2x2; along rows and
/// columns. `None` where too little counts.
pub(super) fn sharpness(luma: &Luma) -> Option<f64> {
    let (fine, n) = detail(luma);
    let (coarse, m) = detail(&halved(luma));
    let is_known = n >= FEWEST && m >= FEWEST && coarse > 1e-3;
    is_known.then(|| fine / coarse)
}

/// The mean size of second differences, and of how many places.
fn detail(luma: &Luma) -> (f64, usize) {
    let [width, height] = luma.size;
    let (mut sum, mut n) = (0.0, 0);
    let mut add = |i: usize, step: usize| {
        let [a, b, c] = [i - step, i, i + step];
        if luma.counts[a] && luma.counts[b] && luma.counts[c] {
            let v = &luma.values;
            sum += f64::from((2.0 * v[b] - v[a] - v[c]).abs());
            n += 1;
        }
    };
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            add(y * width + x, 1);
            add(y * width + x, width);
        }
    }
    (sum / n.max(1) as f64, n)
}

/// Blocks of 2x2 pixels; they count where all four do.
fn halved(luma: &Luma) -> Luma {
    let [width, _] = luma.size;
    let size = luma.size.map(|side| side / 2);
    let blocks = (0..size[0] * size[1]).map(|i| {
        let first = i / size[0] * 2 * width + i % size[0] * 2;
        [first, first + 1, first + width, first + width + 1]
    });
    let (values, counts) = blocks
        .map(|block| {
            let value = block.iter().map(|i| luma.values[*i]).sum::<f32>() / 4.0;
            (value, block.iter().all(|i| luma.counts[*i]))
        })
        .unzip();
    Luma { size, values, counts }
}
