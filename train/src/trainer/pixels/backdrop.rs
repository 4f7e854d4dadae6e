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
    /// Nothing: the scene fills opaque images, so that a ray may not pass through it. Pictures
    /// are shown on this colour, and a share of light that passes costs what it does on average
    /// over random colours.
    Hidden([f32; 3]),
}

/// Variance of a channel of random colours.
const RANDOM: f32 = 1.0 / 12.0;

impl Backdrop {
    /// Mean of each channel and variance of all.
    pub(super) fn moments(self) -> ([f32; 3], f32) {
        match self {
            Self::Random => ([0.5; 3], RANDOM),
            Self::Color(color) => (color, 0.0),
            Self::Hidden(color) => (color, RANDOM),
        }
    }
}
