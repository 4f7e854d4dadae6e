//! The caller's coordinates.

use crate::Error;

/// The similarity transform from a model's coordinates (scene units) to the caller's,
/// the dataset's as a rule: `dataset = scale * rotation * model + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Dataset units per scene unit, from 1e-6 to 1e6.
    pub scale: f32,
    /// A proper rotation, row after row.
    pub rotation: [[f32; 3]; 3],
    /// Dataset coordinates of the model's origin, dataset units, at most 1e11.
    pub translation: [f32; 3],
}

/// Coordinates beyond this, in the caller's units, are no place: their squares would leave
/// f32's range.
const FARTHEST: f32 = 1e11;

impl Similarity {
    /// The model's own coordinates.
    pub const IDENTITY: Self = Self {
        scale: 1.0,
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        let sound = (1e-6..=1e6).contains(&self.scale)
            && is_rotation(&self.rotation)
            && are_places(&self.translation);
        sound.then_some(()).ok_or(Error::Range("coordinates: scale, rotation and translation"))
    }

    /// A point in scene units to dataset coordinates.
    #[must_use]
    pub fn to_dataset(&self, p: [f32; 3]) -> [f32; 3] {
        let row = |i: usize| -> f32 {
            let r = self.rotation[i];
            self.scale * (r[0] * p[0] + r[1] * p[1] + r[2] * p[2]) + self.translation[i]
        };
        [row(0), row(1), row(2)]
    }

    /// A direction in dataset coordinates as one in the model's, of the same length.
    #[inline]
    #[must_use]
    pub fn to_model_direction(&self, d: [f32; 3]) -> [f32; 3] {
        // The inverse of a rotation is its transpose.
        let r = &self.rotation;
        [0, 1, 2].map(|i| r[0][i] * d[0] + r[1][i] * d[1] + r[2][i] * d[2])
    }

    /// A direction in the model's coordinates as one in the dataset's, of the same length.
    #[must_use]
    pub fn to_dataset_direction(&self, d: [f32; 3]) -> [f32; 3] {
        self.rotation.map(|r| r[0] * d[0] + r[1] * d[1] + r[2] * d[2])
    }

    /// A point in dataset coordinates to scene units.
    #[inline]
    #[must_use]
    pub fn to_model(&self, p: [f32; 3]) -> [f32; 3] {
        self.to_model_direction([0, 1, 2].map(|i| (p[i] - self.translation[i]) / self.scale))
    }

    /// How far at most rounding takes `p` on its way to scene units, and how much longer
    /// at most lengths become, because three digits suffice for a rotation.
    pub(super) fn error(&self, p: [f32; 3]) -> [f32; 2] {
        let largest = |v: [f32; 3]| v.iter().fold(0.0, |most: f32, v| most.max(v.abs()));
        let rounding = 16.0 * f32::EPSILON * (largest(p) + largest(self.translation)) / self.scale;
        // |R x|² is at most |x|² times 1 and the Frobenius norm of R Rᵀ - 1.
        let r = &self.rotation;
        let mut squares = 0.0;
        for (i, a) in r.iter().enumerate() {
            for (k, b) in r.iter().enumerate() {
                let dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
                let off = dot - if i == k { 1.0 } else { 0.0 };
                squares += off * off;
            }
        }
        [rounding, 1.0 + crate::math::sqrt(squares) + 8.0 * f32::EPSILON]
    }
}

/// Whether the rows are orthonormal and right-handed, to three digits. False for NaN.
#[inline]
#[must_use]
pub fn is_rotation(r: &[[f32; 3]; 3]) -> bool {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let [a, b, c] = *r;
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let close = |value: f32, to: f32| (value - to).abs() < 1e-3;
    close(dot(a, a), 1.0)
        && close(dot(b, b), 1.0)
        && close(dot(c, c), 1.0)
        && close(dot(a, b), 0.0)
        && close(dot(cross, c), 1.0)
}

/// Whether coordinates say where something is. False for NaN.
#[inline]
pub(super) fn are_places(coordinates: &[f32]) -> bool {
    coordinates.iter().all(|v| v.abs() <= FARTHEST)
}
