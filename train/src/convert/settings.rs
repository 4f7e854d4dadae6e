//! How a checkpoint's networks are rendered, which it does not store.

use pocketnerf_core::march::{Hierarchical, MAX_SAMPLES, Reach};
use pocketnerf_formats::PixelOrigin;

use super::ConvertError;

/// What is known so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Depth where samples begin, scene units.
    pub near: Option<f32>,
    /// Depth where they end.
    pub far: Option<f32>,
    /// Evenly spaced samples, and those that are drawn from their weights.
    pub samples: [Option<u32>; 2],
    /// Colour behind the scene.
    pub background: Option<[f32; 3]>,
    /// Whether rays are those of normalised device coordinates.
    pub ndc: Option<bool>,
    /// Where in a pixel rays go through.
    pub pixel_origin: Option<PixelOrigin>,
    /// Whether near and far are distances along rays, not depths along the camera's axis.
    pub along_rays: Option<bool>,
}

/// Everything that a picture needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Complete {
    pub(super) near: f32,
    pub(super) far: f32,
    pub(super) hierarchical: Hierarchical,
    pub(super) background: [f32; 3],
    pub(super) ndc: bool,
    pub(super) pixel_origin: PixelOrigin,
}

impl Settings {
    /// These, and what they leave open from `others`.
    #[must_use]
    pub fn or(self, others: Self) -> Self {
        let [coarse, fine] = [0, 1].map(|i| self.samples[i].or(others.samples[i]));
        Self {
            near: self.near.or(others.near),
            far: self.far.or(others.far),
            samples: [coarse, fine],
            background: self.background.or(others.background),
            ndc: self.ndc.or(others.ndc),
            pixel_origin: self.pixel_origin.or(others.pixel_origin),
            along_rays: self.along_rays.or(others.along_rays),
        }
    }

    /// All of them. By default rays pass through corners and depths are along the axis, as in
    /// all programs.
    pub(super) fn complete(self) -> Result<Complete, ConvertError> {
        let ndc = self.ndc.unwrap_or(false);
        let mut missing = Vec::new();
        // All of the ray, there.
        let (near, far) = if ndc { (Some(0.0), Some(1.0)) } else { (self.near, self.far) };
        for (what, there) in [
            ("--near", near.is_some()),
            ("--far", far.is_some()),
            ("--samples", self.samples.iter().all(Option::is_some)),
            ("--background", self.background.is_some()),
        ] {
            if !there {
                missing.push(what);
            }
        }
        let (Some(near), Some(far), [Some(n_coarse), Some(n_fine)], Some(background)) =
            (near, far, self.samples, self.background)
        else {
            return Err(ConvertError::Missing(missing.join(" ")));
        };
        let in_order = near >= 0.0 && near < far && far < 1e6;
        if !in_order {
            return Err(ConvertError::Bounds { near, far });
        }
        if !(4..=MAX_SAMPLES).contains(&n_coarse) || n_fine > MAX_SAMPLES {
            return Err(ConvertError::Samples { n_coarse, n_fine, most: MAX_SAMPLES });
        }
        let along_rays = self.along_rays.unwrap_or(false);
        let reach = if along_rays { Reach::Distance } else { Reach::Depth };
        Ok(Complete {
            near,
            far,
            hierarchical: Hierarchical { n_coarse, n_fine, reach },
            background,
            ndc,
            pixel_origin: self.pixel_origin.unwrap_or(PixelOrigin::Corner),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named() {
        let none = Settings::default().complete().unwrap_err().to_string();
        assert!(none.contains("--near --far --samples --background"), "{none}");
        let some = Settings {
            near: Some(2.0),
            far: Some(6.0),
            samples: [Some(64), None],
            background: Some([1.0; 3]),
            ..Settings::default()
        };
        let error = some.complete().unwrap_err().to_string();
        assert!(error.contains("--samples") && !error.contains("--near"), "{error}");
        let rest = Settings { near: Some(9.0), samples: [None, Some(32)], ..Settings::default() };
        let all = some.or(rest).complete().unwrap();
        assert_eq!((all.near, all.hierarchical.n_fine, all.ndc), (2.0, 32, false));
        assert_eq!(all.pixel_origin, PixelOrigin::Corner);
        let wrong = Settings { far: Some(1.0), ..some.or(rest) };
        assert!(matches!(wrong.complete(), Err(ConvertError::Bounds { .. })));
        let wrong = Settings { samples: [Some(3), Some(0)], ..some };
        assert!(matches!(wrong.complete(), Err(ConvertError::Samples { .. })));
    }
}
