//! The actual clock of a core.

use std::hint::black_box;

/// Instructions of one call, each of which waits for the one before.
pub(super) const CYCLES: f64 = (2 * PAIRS) as f64;

const PAIRS: u64 = 1 << 16;

/// Alternating additions and exclusive ors, which no compiler can merge: each takes one
/// cycle.
pub(super) fn chain() {
    let (mut x, a, b) = (black_box(1u64), black_box(3u64), black_box(5u64));
    for _ in 0..PAIRS / 8 {
        for _ in 0..8 {
            x = x.wrapping_add(a) ^ b;
        }
    }
    black_box(x);
}
