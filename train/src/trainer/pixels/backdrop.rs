//! What lies behind the training images.

/// What lies behind the training images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backdrop {
    /// All colours alike: what is transparent must become empty. For images with
    /// alpha. The error is what it is on average over random colours, which is known
    /// from their mean and variance: nothing is drawn.
    Random,
    /// Always this colour.
    Color([f32; 3]),
}

impl Backdrop {
    /// Mean of each channel and variance of all.
    pub(super) fn moments(self) -> ([f32; 3], f32) {
        match self {
            Self::Random => ([0.5; 3], 1.0 / 12.0),
            Self::Color(color) => (color, 0.0),
        }
    }
}
