//! The two types that a network is computed in.

use std::iter::Sum;

use ndarray::NdFloat;

/// f32 or f64.
pub(crate) trait Real: NdFloat + Sum {
    /// The nearest value.
    fn of(value: f64) -> Self;

    /// As f64.
    fn value(self) -> f64;

    /// 1 / (1 + e⁻ˣ).
    fn sigmoid(self) -> Self {
        Self::one() / (Self::one() + (-self).exp())
    }

    /// ln(1 + eˣ), which does not overflow.
    fn softplus(self) -> Self {
        self.max(Self::zero()) + (-self.abs()).exp().ln_1p()
    }
}

impl Real for f32 {
    fn of(value: f64) -> Self {
        value as Self
    }

    fn value(self) -> f64 {
        self.into()
    }
}

impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }
}
