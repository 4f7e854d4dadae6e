//! How fast a path is passed.

/// How fast a path is passed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// Always as fast.
    #[default]
    Even,
    /// Slowly at both ends: after a share p of the time, 3 p² − 2 p³ of the path is passed.
    Eased,
}

impl Pace {
    /// The share of the path that is passed after this share of the time, both from 0 to 1.
    #[must_use]
    pub fn at(self, time: f32) -> f32 {
        match self {
            Self::Even => time,
            Self::Eased => time * time * (3.0 - 2.0 * time),
        }
    }
}
