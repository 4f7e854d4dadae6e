//! Which parts of photographs count: alpha and masks that are everywhere the same, or the wrong
//! way round.

use super::photo::Photo;
use super::{Suspect, Suspicion};

/// Shares of what counts, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cover {
    /// Of all pixels.
    pub(super) all: f64,
    /// Of the middle half of both sides.
    pub(super) middle: f64,
    /// Of the outer tenth of the sides.
    pub(super) edge: f64,
    /// Whether any pixel counts, if only in part.
    pub(super) any: bool,
    /// Share of pixels that do not count in full.
    pub(super) transparent: f64,
}

impl Cover {
    /// Of `size[0]` by `size[1]` values in 0 to 1, row after row.
    pub(super) fn of([width, height]: [u32; 2], values: impl Iterator<Item = f64>) -> Self {
        let (w, h) = (u64::from(width.max(1)), u64::from(height.max(1)));
        let (mut sums, mut counts) = ([0.0; 4], [0u64; 3]);
        for (i, value) in (0..).zip(values) {
            let (x, y) = (i % w, i / w);
            let is_middle = (w / 4..w - w / 4).contains(&x) && (h / 4..h - h / 4).contains(&y);
            let inner = |at: u64, side: u64| (side / 10 + 1..side - side / 10 - 1).contains(&at);
            let is_edge = w > 20 && h > 20 && !(inner(x, w) && inner(y, h));
            for (part, holds) in [true, is_middle, is_edge].into_iter().enumerate() {
                if holds {
                    sums[part] += value;
                    counts[part] += 1;
                }
            }
            sums[3] += if value < 1.0 { 1.0 } else { 0.0 };
        }
        let share = |sum: f64, count: u64| if count > 0 { sum / count as f64 } else { 0.0 };
        Self {
            all: share(sums[0], counts[0]),
            middle: share(sums[1], counts[1]),
            edge: share(sums[2], counts[2]),
            any: sums[0] > 0.0,
            transparent: share(sums[3], counts[0]),
        }
    }

    /// Whether edges count and the middle does not.
    fn is_inside_out(self) -> bool {
        self.middle < 0.35 && self.edge > 0.85
    }
}

/// Where a share of the photographs as large as this is inside out, they are the wrong way round.
const MOST: f64 = 0.6;
/// A cut-out has at least one transparent pixel in so many.
const CUT_OUT: f64 = 1e-3;

pub(super) fn find(suspect: &Suspect<'_, '_>, photos: &[Option<Photo>]) -> Vec<Suspicion> {
    let mut found = Vec::new();
    let of = |pick: fn(&Photo) -> Option<Cover>| -> Vec<(usize, Cover)> {
        let numbered = photos.iter().enumerate();
        numbered.filter_map(|(i, photo)| Some((i, pick(photo.as_ref()?)?))).collect()
    };
    let which = |covers: &[(usize, Cover)], holds: &dyn Fn(&Cover) -> bool| -> Vec<usize> {
        covers.iter().filter(|(_, cover)| holds(cover)).map(|(i, _)| *i).collect()
    };
    let (alpha, masks) = (of(|photo| photo.alpha), of(|photo| photo.mask));
    let mut add = |kind, what: &str, which: Vec<usize>, then: &str| {
        if !which.is_empty() {
            found.push(Suspicion::new(kind, format!("{}; {then}", suspect.some(what, &which))));
        }
    };
    let most = |which: Vec<usize>, of: &[(usize, Cover)]| match which.len() as f64 {
        n if n > MOST * of.len() as f64 => which,
        _ => Vec::new(),
    };
    add(
        "alpha-empty",
        "images that are transparent everywhere (alpha 0)",
        which(&alpha, &|cover| !cover.any),
        "correct their alpha, or take the frames out",
    );
    add(
        "alpha-inverted",
        "images that are opaque around a transparent middle",
        most(which(&alpha, &|cover| cover.is_inside_out()), &alpha),
        "if alpha is the wrong way round, invert it",
    );
    let opaque = which(&alpha, &|cover| cover.transparent == 0.0);
    let cut_outs = which(&alpha, &|cover| cover.transparent >= CUT_OUT);
    add(
        "alpha-full",
        "images that are opaque everywhere (alpha 255), while most are cut out",
        if cut_outs.len() > opaque.len() { opaque } else { Vec::new() },
        "give them their alpha, or take the frames out",
    );
    add(
        "mask-empty",
        "masks that are black everywhere",
        which(&masks, &|cover| !cover.any),
        "nothing counts there; correct them, or take the frames out",
    );
    let inverted = which(&masks, &|cover| cover.any && (cover.is_inside_out() || cover.all < 0.05));
    add(
        "mask-inverted",
        "masks that leave out the middle, or nearly all",
        most(inverted, &masks),
        "if masks are the wrong way round, invert them",
    );
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_by_hand() {
        // A square of 20x20 in a picture of 40x40: the middle half. Edges are 5 wide.
        let square = (0..1600).map(|i| {
            let (x, y) = (i % 40, i / 40);
            if (10..30).contains(&x) && (10..30).contains(&y) { 1.0 } else { 0.0 }
        });
        let cover = Cover::of([40, 40], square.clone());
        let expected = Cover { all: 0.25, middle: 1.0, edge: 0.0, any: true, transparent: 0.75 };
        assert_eq!(cover, expected);
        assert!(!cover.is_inside_out());
        assert!(Cover::of([40, 40], square.map(|v| 1.0 - v)).is_inside_out());
        assert!(!Cover::of([0, 0], std::iter::empty()).any);
    }
}
