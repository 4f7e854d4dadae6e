//! Rays on their way, as they lie in the caller's scratch: sixteen together.

use crate::composite::{self, Gathered};
use crate::sampler::{Bundle, LANES};
use crate::scratch::RAY_ROWS;

/// Sixteen rays in flight, a row a number.
pub(super) type Rows = [[f32; LANES]; RAY_ROWS];

/// The direction; a [`Bundle`]'s rows come first.
pub(super) const DIRECTION: core::ops::Range<usize> = 3..6;
const NEXT: usize = 7;
const END: usize = 8;
const TRANSMITTANCE: usize = 9;
const OPACITY: usize = 10;
const DEPTH: usize = 11;
/// Part of the light that passed the ray's last sample.
const PASSED: usize = 12;
/// The bits of the number of the ray's pixel.
const PIXEL: usize = 13;

/// Steps that the ray's samples of this round stand for.
const STEPS: usize = 14;

/// The bundle in the first rows.
#[inline(always)]
pub(super) fn bundle(rows: &Rows) -> Bundle {
    let [ox, oy, oz, dx, dy, dz, phase, next, end, ..] = *rows;
    Bundle { origin: [ox, oy, oz], direction: [dx, dy, dz], phase, next, end }
}

/// Puts a lane of a bundle, which has gathered nothing, into a lane of the rows.
#[inline(always)]
pub(super) fn start(rows: &mut Rows, to: usize, bundle: &Bundle, from: usize, pixel: u32) {
    let Bundle { origin: [ox, oy, oz], direction: [dx, dy, dz], phase, next, end } = bundle;
    let rays = [ox, oy, oz, dx, dy, dz, phase, next, end];
    let (first, rest) = rows.split_at_mut(rays.len());
    for (row, value) in first.iter_mut().zip(rays) {
        row[to] = value[from];
    }
    let fresh = [1.0, 0.0, 0.0, 1.0, f32::from_bits(pixel), 1.0];
    for (row, value) in rest.iter_mut().zip(fresh) {
        row[to] = value;
    }
}

/// Ends a ray.
#[inline(always)]
pub(super) fn stop(rows: &mut Rows, lane: usize) {
    rows[NEXT][lane] = rows[END][lane];
}

/// Whether any of the rays has steps left.
#[inline(always)]
pub(super) fn any_alive(rows: &Rows) -> bool {
    rows[NEXT].iter().zip(&rows[END]).any(|(next, end)| next < end)
}

/// Notes how far the rays have come.
#[inline(always)]
pub(super) fn moved(rows: &mut Rows, bundle: &Bundle) {
    rows[NEXT] = bundle.next;
}

/// The number of a ray's pixel.
#[inline(always)]
pub(super) fn pixel(rows: &Rows, lane: usize) -> usize {
    rows[PIXEL][lane].to_bits() as usize
}

/// What a ray has gathered.
#[inline(always)]
pub(super) fn gathered(rows: &Rows, lane: usize) -> Gathered {
    Gathered {
        transmittance: rows[TRANSMITTANCE][lane],
        opacity: rows[OPACITY][lane],
        depth: rows[DEPTH][lane],
    }
}

/// Notes what a ray has gathered, and the opacity of its last sample.
#[inline(always)]
pub(super) fn gather(rows: &mut Rows, lane: usize, gathered: &Gathered, alpha: f32) {
    rows[TRANSMITTANCE][lane] = gathered.transmittance;
    rows[OPACITY][lane] = gathered.opacity;
    rows[DEPTH][lane] = gathered.depth;
    rows[PASSED][lane] = 1.0 - alpha;
}

/// Chooses how many steps the rays' next samples stand for.
#[inline(always)]
pub(super) fn choose_steps(rows: &mut Rows, late: f32) -> [f32; LANES] {
    let chosen = rows[TRANSMITTANCE].map(|t| {
        if t >= late {
            1.0
        } else if t >= late * 0.25 {
            2.0
        } else {
            4.0
        }
    });
    rows[STEPS] = chosen;
    chosen
}

/// Steps that a ray's sample of this round stands for.
#[inline(always)]
pub(super) fn steps(rows: &Rows, lane: usize) -> f32 {
    rows[STEPS][lane]
}

/// Samples that rays will still need, at most `most`.
#[inline(always)]
pub(super) fn samples_needed(rows: &Rows, min_transmittance: f32, most: usize) -> [f32; LANES] {
    composite::samples_needed(&rows[TRANSMITTANCE], &rows[PASSED], min_transmittance, most)
}
