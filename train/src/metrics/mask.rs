//! Which pixels of a picture count.

/// A byte a pixel, 0 where it does not count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mask<'m> {
    bytes: Option<&'m [u8]>,
    size: [usize; 2],
}

impl<'m> Mask<'m> {
    /// All count.
    pub(super) const NONE: Self = Self { bytes: None, size: [0; 2] };

    /// A mask of a picture of `size`, width and height.
    ///
    /// # Panics
    /// If it is of another size.
    pub(super) fn new(bytes: Option<&'m [u8]>, size: [usize; 2]) -> Self {
        assert!(bytes.is_none_or(|mask| mask.len() == size[0] * size[1]), "a byte a pixel");
        Self { bytes, size }
    }

    /// Whether what is under the middle of pixel (`x`, `y`) counts, in a version of the picture
    /// that has another `size`.
    #[inline]
    pub(super) fn counts(&self, [x, y]: [usize; 2], size: [usize; 2]) -> bool {
        let under = |a: usize, i: usize| (2 * i + 1) * self.size[a] / (2 * size[a]);
        self.bytes.is_none_or(|mask| mask[under(1, y) * self.size[0] + under(0, x)] != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smaller_version_looks_at_the_middles() {
        let bytes = [1, 0, 0, 1, 0, 1, 0, 0];
        let mask = Mask::new(Some(&bytes), [4, 2]);
        assert!((0..8).all(|i| mask.counts([i % 4, i / 4], [4, 2]) == (bytes[i] != 0)));
        // Middles at (1, 1) and (3, 1).
        assert_eq!([0, 1].map(|x| mask.counts([x, 0], [2, 1])), [true, false]);
        assert!(Mask::NONE.counts([7, 7], [8, 8]));
    }
}
