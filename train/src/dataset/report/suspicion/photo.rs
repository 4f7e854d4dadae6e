//! What photographs show, in few numbers. They are decoded for it, as many as is quick.

use rayon::prelude::*;

use super::super::shot::Shot;
use super::cover::Cover;
use crate::dataset::images::{self, Image};
use crate::dataset::listing::Mask;

/// Pixels that are decoded, of all photographs together: some seconds on two cores.
const PIXELS: u64 = 200_000_000;
/// A photograph with more pixels is passed over.
const LARGEST: u64 = 150_000_000;
/// Luma that is dark or bright without measure says nothing of the exposure.
const SEEN: std::ops::Range<usize> = 2..254;

/// What a photograph shows.
#[derive(Clone, Debug)]
pub(super) struct Photo {
    /// Mean of the luma that counts, linear, 0 to 1; `None` where nothing counts.
    pub(super) light: Option<f64>,
    /// Standard deviation of the luma that counts, of 255; `None` where nothing counts.
    pub(super) deviation: Option<f64>,
    /// How much detail of single pixels there is beside detail of two pixels.
    pub(super) sharpness: Option<f64>,
    /// Where it is opaque, if it has alpha.
    pub(super) alpha: Option<Cover>,
    /// Where it counts, if it has a mask.
    pub(super) mask: Option<Cover>,
}

/// Luma of an image's pixels, and which of them count.
pub(super) struct Luma {
    pub(super) size: [usize; 2],
    /// 0 to 255.
    pub(super) values: Vec<f32>,
    pub(super) counts: Vec<bool>,
}

/// One for each frame; `None` where it is not decoded or cannot be.
pub(super) fn all(shots: &[&Shot<'_>]) -> Vec<Option<Photo>> {
    let pixels =
        |shot: &Shot<'_>| shot.header.map_or(0, |h| u64::from(h.size[0]) * u64::from(h.size[1]));
    let total: u64 = shots.iter().map(|shot| pixels(shot)).sum();
    let apart = total.div_ceil(PIXELS).max(1) as usize;
    let photo = |(i, shot): (usize, &&Shot<'_>)| {
        let is_looked_at = i.is_multiple_of(apart) && pixels(shot) <= LARGEST;
        if is_looked_at { Photo::of(shot) } else { None }
    };
    shots.par_iter().enumerate().map(photo).collect()
}

impl Photo {
    fn of(shot: &Shot<'_>) -> Option<Self> {
        let header = shot.header?;
        let mut image = images::decode(shot.file.as_deref()?).ok()?;
        let mut has_alpha = header.alpha;
        if let Some(path) = &shot.frame.alpha {
            let alpha = images::decode(&shot.folder.join(path)).ok()?;
            if alpha.size == image.size {
                has_alpha = true;
                let (to, from) = (image.rgba.iter_mut().skip(3), alpha.rgba.iter());
                to.step_by(4).zip(from.step_by(4)).for_each(|(to, from)| *to = *from);
            }
        }
        let mask = shot.frame.mask.as_ref().and_then(|mask| counting(shot, mask));
        let opaque = image.rgba.iter().skip(3).step_by(4);
        let alpha = has_alpha.then(|| Cover::of(image.size, opaque.map(|a| f64::from(*a) / 255.0)));
        let cover = mask.as_ref().map(|(size, counts)| {
            Cover::of(*size, counts.iter().map(|counts| f64::from(u8::from(*counts))))
        });
        let luma = Luma::of(&image, mask.filter(|(size, _)| *size == image.size).map(|m| m.1));
        let histogram = luma.histogram();
        let middle = mean(&histogram, |value| value);
        let square = middle.and_then(|middle| mean(&histogram, |value| (value - middle).powi(2)));
        Some(Self {
            light: mean(&histogram[SEEN], |value| ((value + SEEN.start as f64) / 255.0).powf(2.2)),
            deviation: square.map(f64::sqrt),
            sharpness: super::sharp::sharpness(&luma),
            alpha,
            mask: cover,
        })
    }
}

/// The size of a mask and which pixels count by it.
fn counting(shot: &Shot<'_>, mask: &Mask) -> Option<([u32; 2], Vec<bool>)> {
    let image = images::decode(&shot.folder.join(&mask.path)).ok()?;
    let is_black = |p: &[u8; 4]| (p[0] | p[1] | p[2]) == 0;
    let pixels = image.rgba.as_chunks().0.iter();
    Some((image.size, pixels.map(|pixel| is_black(pixel) == mask.black_counts).collect()))
}

impl Luma {
    fn of(image: &Image, mask: Option<Vec<bool>>) -> Self {
        let pixels = image.rgba.as_chunks::<4>().0;
        let luma = |p: &[u8; 4]| {
            0.299 * f32::from(p[0]) + 0.587 * f32::from(p[1]) + 0.114 * f32::from(p[2])
        };
        let opaque = pixels.iter().map(|pixel| pixel[3] == u8::MAX);
        let counts = match mask {
            Some(mask) => opaque.zip(mask).map(|(opaque, counts)| opaque && counts).collect(),
            None => opaque.collect(),
        };
        let size = image.size.map(|side| side as usize);
        Self { size, values: pixels.iter().map(luma).collect(), counts }
    }
}

impl Luma {
    /// How many pixels that count have each value, rounded.
    fn histogram(&self) -> [u64; 256] {
        let mut histogram = [0; 256];
        for (value, _) in self.values.iter().zip(&self.counts).filter(|(_, counts)| **counts) {
            histogram[(value.round() as usize).min(255)] += 1;
        }
        histogram
    }
}

/// The mean of something of each value; values are numbered from 0 on.
fn mean(histogram: &[u64], of: impl Fn(f64) -> f64) -> Option<f64> {
    let all: u64 = histogram.iter().sum();
    let each = histogram.iter().enumerate().map(|(value, n)| *n as f64 * of(value as f64));
    (all > 0).then(|| each.sum::<f64>() / all as f64)
}
