//! What tests of gradients ask core's oracle.

use pocketnerf_core::{AnyField, ColorSpace, Display, Model, Sampling, Space};

/// A field whose unit coordinates are scene coordinates.
pub(super) fn in_unit_cube(field: AnyField<'_>) -> Model<'_> {
    Model {
        field,
        space: Space::Box { min: [0.0; 3], max: [1.0; 3] },
        occupancy: None,
        sampling: Sampling { step: 0.01, near: 0.0, far: 10.0, min_transmittance: 0.0 },
        hierarchical: None,
        display: Display {
            background: [0.0; 3],
            color_space: ColorSpace::Srgb,
            tolerance: Display::TOLERANCE,
        },
    }
}
