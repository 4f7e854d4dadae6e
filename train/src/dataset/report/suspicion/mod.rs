//! What is suspicious about a dataset, a line each, with what to do.
//!
//! Bounds are such that sound scenes are silent: the built-in ones, lego, fern, fox and tumbler.

mod cover;
mod direction;
mod files;
mod lens;
mod light;
mod number;
mod photo;
mod place;
mod sharp;
mod twice;

use glam::DVec3;
use serde::Serialize;

use super::shot::{Shot, distinct};
use crate::dataset::Split;
use crate::dataset::listing::Listing;
use crate::json::escape;

/// What may be wrong with a dataset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Suspicion {
    /// A word for programs, such as `poses-convention`.
    pub kind: &'static str,
    /// One line: what was found, what was expected, what to do.
    pub text: String,
}

impl Suspicion {
    fn new(kind: &'static str, text: impl Into<String>) -> Self {
        Self { kind, text: text.into() }
    }
}

/// What the checks look at.
struct Suspect<'s, 'l> {
    /// The frames of all splits, each once.
    shots: Vec<&'s Shot<'l>>,
    /// Of the first split: what is known of the scene.
    listing: &'l Listing,
}

/// Where a camera is and along which direction it looks.
#[derive(Clone, Copy, Debug)]
struct Sight {
    position: DVec3,
    /// Of length 1.
    forward: DVec3,
}

/// All that is suspicious about the frames of all splits.
pub(super) fn find(splits: &[Vec<Shot<'_>>], listing: &Listing) -> Vec<Suspicion> {
    let suspect = Suspect { shots: distinct(splits), listing };
    let photos = photo::all(&suspect.shots);
    let (cameras, twice) = (direction::find(&suspect), twice::find(&suspect));
    let are_placed = cameras.is_empty() && twice.is_empty();
    let number = number::find(&suspect, are_placed);
    let cover = cover::find(&suspect, &photos);
    // What does not count is no part of a photograph, and neighbours must be some.
    let (is_shown, are_near) = (cover.is_empty(), are_placed && number.is_none());
    let mut found = files::find(&suspect);
    found.extend(number);
    found.extend(cameras);
    found.extend(lens::find(&suspect));
    found.extend(twice);
    found.extend(cover);
    if is_shown {
        found.extend(light::flat(&suspect, &photos));
        found.extend(are_near.then(|| light::exposure(&suspect, &photos)).flatten());
        found.extend(sharp::find(&suspect, &photos));
    }
    found
}

impl<'s, 'l> Suspect<'s, 'l> {
    fn poses(&self) -> Vec<[f32; 16]> {
        self.shots.iter().map(|shot| shot.frame.pose).collect()
    }

    fn sights(&self) -> Vec<Sight> {
        self.poses().iter().map(Sight::of).collect()
    }

    /// What it is, and how many of all frames: `blurred photographs: 3 of 60 (first: train/7.png)`.
    fn some(&self, what: &str, which: &[usize]) -> String {
        let first = which.first().map_or("", |i| self.shots[*i].name());
        format!("{what}: {} of {} (first: {})", which.len(), self.shots.len(), escape(first))
    }

    /// The numbers of the frames of which this holds.
    fn which(&self, holds: impl Fn(&Shot<'_>) -> bool) -> Vec<usize> {
        (0..self.shots.len()).filter(|i| holds(self.shots[*i])).collect()
    }

    /// The frames to learn from; all, where there are none.
    fn training(&self) -> Self {
        let train: Vec<_> = self.of_split(Split::Train).collect();
        let shots = if train.is_empty() { self.shots.clone() } else { train };
        Self { shots, listing: self.listing }
    }

    fn of_split(&self, split: Split) -> impl Iterator<Item = &'s Shot<'l>> {
        self.shots.iter().copied().filter(move |shot| shot.split == split)
    }
}

impl Sight {
    fn of(pose: &[f32; 16]) -> Self {
        let column = |a: usize| DVec3::new(pose[a].into(), pose[4 + a].into(), pose[8 + a].into());
        Self { position: column(3), forward: -column(2).normalize_or_zero() }
    }

    /// The angle between where it looks and a point, degrees; 180 at the point itself, as near as
    /// digits go.
    fn angle_to(&self, point: DVec3) -> f64 {
        let to = point - self.position;
        match to.length() <= 1e-5 * self.position.length() {
            true => 180.0,
            false => self.forward.angle_between(to).to_degrees(),
        }
    }
}

/// The least that is at least as large as a share `q` of the values, which may be in any order.
fn at(values: impl Iterator<Item = f64>, q: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    crate::metrics::quantile(&values, q).unwrap_or(0.0)
}

/// A number for people: `0.250`, `4.0e5`.
fn shown(number: f64) -> String {
    let is_plain = number == 0.0 || (1e-3..1e4).contains(&number.abs());
    if is_plain { format!("{number:.3}") } else { format!("{number:.1e}") }
}
