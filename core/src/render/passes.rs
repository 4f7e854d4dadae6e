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

    /// The four neighbours of a pixel that earlier passes have found, two that face
    /// each other and the other two: the corners of the square that it is the middle
    /// of; or the ends of the side that it is the middle of, and the middles of the two
    /// squares beside it. `None` at the tile's edge, where there are fewer.
    #[inline(always)]
    pub(super) fn neighbours(self, [x, y]: [u32; 2]) -> Option<[[u32; 2]; 4]> {
        let around = |lines: Lines, c: u32| [c - self.half, (c + self.half).min(lines.n - 1)];
        match (self.columns.last, self.rows.last) {
            (false, false) => {
                let [left, right] = around(self.columns, x);
                let [top, bottom] = around(self.rows, y);
                Some([[left, top], [right, bottom], [right, top], [left, bottom]])
            }
            (false, true) => {
                let [left, right] = around(self.columns, x);
                let [top, bottom] = self.beside(self.rows, y)?;
                Some([[left, y], [right, y], [x, top], [x, bottom]])
            }
            (true, _) => {
                let [top, bottom] = around(self.rows, y);
                let [left, right] = self.beside(self.columns, x)?;
                Some([[x, top], [x, bottom], [left, y], [right, y]])
            }
        }
    }

    /// The middles of the squares on both sides of line `c`, where there are two.
    #[inline(always)]
    fn beside(self, lines: Lines, c: u32) -> Option<[u32; 2]> {
        let inside = c.is_multiple_of(lines.step) && c > 0 && c + self.half + 1 < lines.n;
        inside.then(|| [c - self.half, c + self.half])
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
                            let neighbours = pass.neighbours([x, y]);
                            for [a, b] in neighbours.into_iter().flatten() {
                                let theirs = pass_of[(b * width + a) as usize];
                                assert!(theirs > 0 && theirs < number + 1, "{x} {y}: {a} {b}");
                                assert!(
                                    a.abs_diff(x) <= pass.half() && b.abs_diff(y) <= pass.half()
                                );
                            }
                            let mut four = neighbours.unwrap_or([[0, 0], [0, 1], [1, 0], [1, 1]]);
                            four.sort_unstable();
                            assert!(four.windows(2).all(|pair| pair[0] < pair[1]), "{x} {y}");
                            let at_edge = |c: u32, n: u32| c == 0 || c + spacing >= n;
                            let at_edge = at_edge(x, width) || at_edge(y, height);
                            assert!(neighbours.is_some() || at_edge, "{x} {y}");
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
