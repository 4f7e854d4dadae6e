//! Back through the logistic that ends a colour network.

/// The least slope for a gradient that leads back inside.
const LEAST_SLOPE: f32 = 0.002;

/// The gradient by what was before the logistic, from that by its `value`.
///
/// In f32 the logistic of 17 is 1, where its slope is 0: a network that once came there, as on
/// white objects in its first steps, would stay there for ever. A gradient that leads back
/// from 0 or 1 is therefore never lost.
#[inline(always)]
pub(super) fn before_logistic(value: f32, d: f32) -> f32 {
    let inside = (value > 0.5) == (d > 0.0);
    d * (value * (1.0 - value)).max(if inside { LEAST_SLOPE } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_the_logistic_unless_it_is_lost() {
        for (value, d, expected) in [
            (0.5, 1.0, 0.25),
            (0.9, 2.0, 0.18),
            (0.9, -2.0, -0.18),
            // Too bright, and as bright as can be.
            (1.0, 0.5, 0.001),
            (0.9999, 0.5, 0.001),
            (0.0, -0.5, -0.001),
            // Not bright enough: nothing is to be gained.
            (1.0, -0.5, 0.0),
            (0.0, 0.5, 0.0),
            (0.0, 0.0, 0.0),
        ] {
            let found = before_logistic(value, d);
            assert!((found - expected).abs() < 1e-6, "{value} {d}: {found}, by hand {expected}");
        }
    }
}
