//! Which pixels of a tile are rendered in which order, and which are
//! interpolated from those around them instead.
//!
//! First a grid of every `spacing`-th pixel along both axes (and the tile's last
//! column and row); then, with half the spacing, the middles of the squares of
//! the grid, and the middles of their sides; and so on down to every pixel. A
//! pixel whose neighbours of the passes before agree is their mean.

/// The columns, or the rows, that a pass visits.
#[derive(Clone, Copy, Debug)]
struct Lines {
    first: u32,
    step: u32,
    n: u32,
    /// Whether the last line belongs to them in any case, or in none.
    last: bool,
}

impl Lines {
    /// Every `step`-th line and the last.
    const fn known(step: u32, n: u32) -> Self {
        Self { first: 0, step, n, last: true }
    }

    /// Those in the middle between the [known](Self::known) ones of twice `half`.
    const fn between(half: u32, n: u32) -> Self {
        Self { first: half, step: 2 * half, n, last: false }
    }

    fn iter(self) -> impl Iterator<Item = u32> + Clone {
        let Self { first, step, n, last } = self;
        let regular = (first..n.saturating_sub(1)).step_by(step as usize);
        regular.chain((last && n > 0).then(|| n - 1))
    }
}

/// Pixels that depend on those of earlier passes alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass {
    columns: Lines,
    rows: Lines,
    /// Distance to the neighbours; 0: the first pass, which has none.
    half: u32,
    /// Whether the next pass reads this one's pixels.
    read_next: bool,
}

/// Which passes of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    /// Spacing of the grid whose pixels are known; 0: none is.
    pub(super) known: u32,
    /// Otherwise, that of the first grid.
    pub(super) grid: u32,
    /// That of the last.
    pub(super) to: u32,
}

impl Span {
    /// From a first grid to every pixel.
    pub(super) const fn all(grid: u32) -> Self {
        Self { known: 0, grid, to: 1 }
    }

    /// The passes over a tile, in their order. Spacings are powers of two.
    pub(super) fn passes(self, [width, height]: [u32; 2]) -> impl Iterator<Item = Pass> {
        let known = move |spacing: u32, half: u32| Pass {
            columns: Lines::known(spacing, width),
            rows: Lines::known(spacing, height),
            half,
            read_next: true,
        };
        let grid = (self.known == 0).then(|| known(self.grid, 0));
        let from = if self.known == 0 { self.grid } else { self.known };
        let halves = (self.to.ilog2()..from.ilog2()).rev().map(|k| 1 << k);
        let finer = halves.flat_map(move |half| {
            let (columns, rows) = (Lines::between(half, width), Lines::between(half, height));
            let old = known(2 * half, half);
            [
                Pass { columns, rows, ..old },
                Pass { columns, read_next: false, ..old },
                Pass { rows, ..old },
            ]
        });
        grid.into_iter().chain(finer)
    }
}

impl Pass {
    /// Columns and rows of its pixels.
    pub(super) fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        let columns = self.columns.iter();
        self.rows.iter().flat_map(move |y| columns.clone().map(move |x| [x, y]))
    }

    /// Whether the pass must be finished before the next begins.
    pub(super) const fn is_read_next(self) -> bool {
        self.read_next
    }

    /// Distance to the neighbours, pixels.
    pub(super) const fn half(self) -> u32 {
        self.half
    }

    /// Calls `each` for the neighbours of a pixel that earlier passes have found:
    /// the corners or the ends of what it is the middle of, and for the middle of
    /// a side also those of the two squares beside it. The first argument is 0 for
    /// two neighbours that face each other, 1 for the other two.
    #[inline(always)]
    pub(super) fn neighbours(self, [x, y]: [u32; 2], mut each: impl FnMut(usize, [u32; 2])) {
        let around = |lines: Lines, c: u32| [c - self.half, (c + self.half).min(lines.n - 1)];
        match (self.columns.last, self.rows.last) {
            (false, false) => {
                let ([left, right], [top, bottom]) =
                    (around(self.columns, x), around(self.rows, y));
                each(0, [left, top]);
                each(0, [right, bottom]);
                each(1, [right, top]);
                each(1, [left, bottom]);
            }
            (false, true) => {
                around(self.columns, x).into_iter().for_each(|x| each(0, [x, y]));
                self.beside(self.rows, y).for_each(|y| each(1, [x, y]));
            }
            (true, _) => {
                around(self.rows, y).into_iter().for_each(|y| each(0, [x, y]));
                self.beside(self.columns, x).for_each(|x| each(1, [x, y]));
            }
        }
    }

    /// The middles of the squares on both sides of line `c`, where there are any.
    #[inline(always)]
    fn beside(self, lines: Lines, c: u32) -> impl Iterator<Item = u32> {
        let regular = c.is_multiple_of(lines.step);
        let before = (regular && c > 0).then(|| c - self.half);
        let after = (regular && c + self.half + 1 < lines.n).then(|| c + self.half);
        before.into_iter().chain(after)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;

    #[test]
    fn every_pixel_once_and_neighbours_come_first() {
        for spacing in [1, 2, 4, 8] {
            for (width, height) in [(1, 1), (1, 9), (2, 3), (16, 16), (17, 8), (31, 5)] {
                let mut pass_of = vec![0; (width * height) as usize];
                for (number, pass) in Span::all(spacing).passes([width, height]).enumerate() {
                    for [x, y] in pass.pixels() {
                        if pass.half() > 0 {
                            let mut n = 0;
                            pass.neighbours([x, y], |_, [a, b]| {
                                let theirs = pass_of[(b * width + a) as usize];
                                assert!(theirs > 0 && theirs < number + 1, "{x} {y}: {a} {b}");
                                assert!(
                                    a.abs_diff(x) <= pass.half() && b.abs_diff(y) <= pass.half()
                                );
                                n += 1;
                            });
                            assert!((2..=4).contains(&n));
                        }
                        let mine = &mut pass_of[(y * width + x) as usize];
                        assert_eq!(*mine, 0, "{x} {y} again");
                        *mine = number + 1;
                    }
                }
                assert!(pass_of.iter().all(|pass| *pass > 0), "{width}x{height} by {spacing}");
            }
        }
    }
}
