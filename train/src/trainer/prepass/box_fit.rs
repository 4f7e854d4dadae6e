//! Whether a box that was given holds the scene, and not much more.

use core::fmt;

use pocketnerf_core::{SimdLevel, Space};

use super::coarse_field::{self, RESOLUTION};
use super::{Deadline, Prepared, PrepassError, find_box};

/// A scene may reach beyond its box by so many cells of the small field: it is known no better.
const BEYOND: f32 = 2.0;
/// And by this share of its own length.
const BEYOND_SHARE: f32 = 0.01;
/// Share of the box's longest side that a scene fills at least: the rest is detail that is lost.
const FILLED: f32 = 0.7;

/// A box that was given beside the one that silhouettes and a small field find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxFit {
    /// Corners of what was given, scene units.
    pub given: [[f32; 3]; 2],
    /// Corners of what was found.
    pub found: [[f32; 3]; 2],
    /// How well these are known, scene units.
    margin: f32,
}

impl Prepared {
    /// How the box fits a scene whose photographs have silhouettes; `None` where there is no
    /// box or no silhouettes.
    /// Trains a small field for a second.
    ///
    /// # Errors
    /// As [`run`](super::run).
    pub fn box_fit(
        self,
        simd: SimdLevel,
        deadline: Deadline,
    ) -> Result<(Self, Option<BoxFit>), PrepassError> {
        let (Some(given), Some(hull)) = (self.space.scene_box(), &self.hull) else {
            return Ok((self, None));
        };
        let Self { source, config, .. } = self;
        let around = find_box(source.cameras(), Some(hull));
        deadline.check()?;
        let (found, source) =
            coarse_field::tighten(around, source, hull, &config, (simd, deadline))?;
        let cell = 1.0 / (RESOLUTION as f32 * around.unit_map().scale);
        let fit = BoxFit { given, found: found.bounds(), margin: BEYOND * cell };
        Ok((Self { source, config, ..self }, Some(fit)))
    }
}

impl BoxFit {
    /// By which share of its length the scene reaches beyond the box, 0 where it does not for all
    /// that is known.
    #[must_use]
    pub fn beyond(&self) -> f32 {
        let Self { given: [low, high], found: [min, max], margin } = self;
        let share = |a: usize| {
            let (side, over) = (max[a] - min[a], (low[a] - min[a]).max(max[a] - high[a]));
            if over > margin + BEYOND_SHARE * side { over / side } else { 0.0 }
        };
        (0..3).map(share).fold(0.0, f32::max)
    }

    /// Which share of the box's longest side the scene fills.
    #[must_use]
    pub fn filled(&self) -> f32 {
        let longest = |[min, max]: [[f32; 3]; 2]| 1.0 / Space::Box { min, max }.unit_map().scale;
        longest(self.found) / longest(self.given)
    }

    /// Whether the box is to be doubted.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        self.beyond() > 0.0 || self.filled() < FILLED
    }
}

impl fmt::Display for BoxFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let beyond = self.beyond();
        if beyond > 0.0 {
            write!(
                f,
                "the scene reaches beyond its box by {:.0} % of its length, expected 0: what lies \
                 outside is lost; ",
                100.0 * beyond
            )?;
        } else {
            write!(
                f,
                "the scene fills {:.0} % of the longest side of its box, expected at least {:.0} %: \
                 details are lost; ",
                100.0 * self.filled(),
                100.0 * FILLED
            )?;
        }
        // Three figures of the longest side.
        let [min, max] = self.found;
        let side = (0..3).map(|a| max[a] - min[a]).fold(0.0, f32::max);
        let digits = (2 - side.log10().floor() as i32).clamp(0, 9) as usize;
        let [x0, y0, z0] = min;
        let [x1, y1, z1] = max;
        let corners = [x0, y0, z0, x1, y1, z1].map(|v| format!("{v:.digits$}")).join(",");
        write!(f, "give --aabb={corners}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(given: [[f32; 3]; 2]) -> BoxFit {
        BoxFit { given, found: [[-1.0; 3], [1.0, 1.0, 0.5]], margin: 0.1 }
    }

    #[test]
    fn a_box_that_cuts_the_scene_and_one_that_loses_details() {
        let sound = fit([[-1.2; 3], [1.2, 0.9, 0.45]]);
        assert!(!sound.is_doubtful(), "{sound}");
        assert!((sound.filled() - 2.0 / 2.4).abs() < 1e-6);
        let cut = fit([[-1.2; 3], [1.2, 1.2, 0.2]]);
        assert!(cut.is_doubtful() && (cut.beyond() - 0.2).abs() < 1e-6);
        assert_eq!(
            cut.to_string(),
            "the scene reaches beyond its box by 20 % of its length, expected 0: what lies outside \
             is lost; give --aabb=-1.00,-1.00,-1.00,1.00,1.00,0.50"
        );
        let large = fit([[-2.0; 3], [2.0; 3]]);
        assert!(large.is_doubtful() && large.beyond() == 0.0);
        assert!(large.to_string().starts_with("the scene fills 50 % of"), "{large}");
    }
}
