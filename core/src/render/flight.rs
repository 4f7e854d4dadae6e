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

/// Steps that each of the ray's samples stands for.
const STEPS: usize = 14;
/// Samples of which that is still true.
const LEFT: usize = 15;

/// Most samples that a ray adds to a batch. Few: nothing is asked behind an
/// opaque surface. Many: fewer rounds.
pub(super) const RUN: usize = 4;

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
    let fresh = [1.0, 0.0, 0.0, 1.0, f32::from_bits(pixel), 1.0, 0.0];
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

/// Whether a ray has steps left.
#[inline(always)]
fn is_alive(rays: &[Rows], ray: usize) -> bool {
    let (rows, lane) = (&rays[ray / LANES], ray % LANES);
    rows[NEXT][lane] < rows[END][lane]
}

/// Brings the first `living` rays that have steps left to the front; gives
/// their number. `swapped` is told which rays have changed places.
#[inline(always)]
pub(super) fn gather_living(
    rays: &mut [Rows],
    mut living: usize,
    mut swapped: impl FnMut(usize, usize),
) -> usize {
    let mut dead = 0;
    loop {
        while dead < living && is_alive(rays, dead) {
            dead += 1;
        }
        while dead < living && !is_alive(rays, living - 1) {
            living -= 1;
        }
        if dead == living {
            return living;
        }
        let (a, b) = (dead, living - 1);
        let (before, after) = rays.split_at_mut(b / LANES);
        let (lane_a, lane_b) = (a % LANES, b % LANES);
        if let Some(rows) = before.get_mut(a / LANES) {
            for (row, other) in rows.iter_mut().zip(&mut after[0]) {
                core::mem::swap(&mut row[lane_a], &mut other[lane_b]);
            }
        } else {
            after[0].iter_mut().for_each(|row| row.swap(lane_a, lane_b));
        }
        swapped(a, b);
    }
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

/// How many samples the rays are to take next, at most `room`, and how many steps
/// each stands for. Steps change after every [`RUN`] samples of a ray and nowhere
/// else: what a ray gathers does not depend on the rays beside it.
#[inline(always)]
pub(super) fn next_samples(
    rows: &mut Rows,
    [min_transmittance, late]: [f32; 2],
    room: usize,
) -> [[f32; LANES]; 2] {
    let needed =
        composite::samples_needed(&rows[TRANSMITTANCE], &rows[PASSED], min_transmittance, room);
    let (mut most, mut steps, mut left) = (needed, rows[STEPS], rows[LEFT]);
    for lane in 0..LANES {
        let chosen = composite::steps(rows[TRANSMITTANCE][lane], late);
        let is_over = left[lane] == 0.0;
        steps[lane] = if is_over { chosen } else { steps[lane] };
        left[lane] = if is_over { RUN as f32 } else { left[lane] };
        most[lane] = most[lane].min(left[lane]);
        left[lane] -= most[lane];
    }
    (rows[STEPS], rows[LEFT]) = (steps, left);
    [most, steps]
}

/// Steps that a ray's sample of this round stands for.
#[inline(always)]
pub(super) fn steps(rows: &Rows, lane: usize) -> f32 {
    rows[STEPS][lane]
}
