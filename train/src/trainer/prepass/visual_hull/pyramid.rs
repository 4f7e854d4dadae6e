//! The silhouette of one view, in ever larger squares of pixels.

/// Of a square of pixels: one of them has alpha.
const SOME: u8 = 1;
/// All of them have.
const ALL: u8 = 2;

/// What ever larger squares of an image show.
#[derive(Debug)]
pub(super) struct Pyramid {
    /// Level 0 is the image itself: width, height, [`SOME`] and [`ALL`] of each square.
    levels: Vec<(usize, usize, Vec<u8>)>,
}

impl Pyramid {
    /// What a pixel that does not count shows is not known: it carves nothing.
    pub(super) fn new(width: usize, height: usize, rgba: &[u8], mask: Option<&[u8]>) -> Self {
        let shows = |alpha: u8| if alpha > 0 { SOME | ALL } else { 0 };
        let mut pixels: Vec<u8> = rgba.iter().skip(3).step_by(4).map(|a| shows(*a)).collect();
        for (pixel, _) in pixels.iter_mut().zip(mask.unwrap_or(&[])).filter(|(_, m)| **m == 0) {
            *pixel = SOME | ALL;
        }
        let mut levels = vec![(width, height, pixels)];
        while let Some((w, h, below)) = levels.last().filter(|(w, h, _)| w.max(h) > &1) {
            let (half_w, half_h) = (w.div_ceil(2), h.div_ceil(2));
            let mut above = vec![ALL; half_w * half_h];
            for y in 0..*h {
                for x in 0..*w {
                    let (to, from) = (&mut above[(y / 2) * half_w + x / 2], below[y * w + x]);
                    *to = (*to | from & SOME) & (from | SOME);
                }
            }
            levels.push((half_w, half_h, above));
        }
        Self { levels }
    }

    /// Whether any pixel of a rectangle (inclusive, inside the image) has
    /// alpha. May say yes a little too often.
    pub(super) fn any(&self, rectangle: [usize; 4]) -> bool {
        // Squares of a quarter of the rectangle: few of them, little beside it.
        self.rows(rectangle, 4).any(|row| row.iter().any(|square| square & SOME != 0))
    }

    /// Whether all of them have. May say no a little too often.
    pub(super) fn all(&self, rectangle: [usize; 4]) -> bool {
        self.rows(rectangle, 2).all(|row| row.iter().all(|square| square & ALL != 0))
    }

    /// The squares that cover a rectangle, with about `across` of them along its longer side.
    fn rows(&self, [x0, y0, x1, y1]: [usize; 4], across: u32) -> impl Iterator<Item = &[u8]> {
        let size = (x1 - x0).max(y1 - y0) + 1;
        let level = size.next_power_of_two().trailing_zeros().saturating_sub(across.ilog2());
        let level = (level as usize).min(self.levels.len() - 1);
        let (w, _, squares) = &self.levels[level];
        let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(|c| c >> level);
        squares[y0 * w..].chunks(*w).take(y1 - y0 + 1).map(move |row| &row[x0..=x1])
    }
}
