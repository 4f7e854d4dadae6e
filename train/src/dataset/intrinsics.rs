//! Focal length and principal point as files give them, and the camera that they
//! make for an image.

use pocketnerf_core::Camera;

use crate::lens::Lens;

/// Along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Focal {
    /// Field of view, radians.
    Angle(f64),
    /// Pixels.
    Pixels(f64),
    /// Image heights.
    Heights(f64),
    /// That with which a whole turn is as wide as the image and half a turn as high.
    Panorama,
}

/// What a file says of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Intrinsics {
    /// Width and height that pixels are counted in; `None`: the image's own.
    pub(super) size: Option<[f64; 2]>,
    /// Along x and y, at least one; `None`: as many pixels as along the other.
    pub(super) focal: [Option<Focal>; 2],
    /// Principal point, pixels; `None`: the middle.
    pub(super) center: [Option<f64>; 2],
    /// Whether other frames have the same: then their images are of one size.
    pub(super) shared: bool,
}

impl Intrinsics {
    /// A horizontal field of view that all frames have, radians.
    pub(super) const fn from_fov_x(angle: f64) -> Self {
        let focal = [Some(Focal::Angle(angle)), None];
        Self { size: None, focal, center: [None; 2], shared: true }
    }

    /// A panorama, perhaps of a known width and height.
    pub(super) const fn panorama(size: Option<[f64; 2]>) -> Self {
        let focal = [Some(Focal::Panorama); 2];
        Self { size, focal, center: [None; 2], shared: false }
    }

    /// Width and height, focal lengths and principal point in pixels, of a camera with this lens;
    /// else what was found and what was expected.
    pub(super) fn from_pixels(
        size: [f64; 2],
        [fx, fy, cx, cy]: [f64; 4],
        lens: &Lens,
    ) -> Result<Self, String> {
        let [width, height] = size;
        if !size.iter().all(|side| (1.0..1e6).contains(side)) {
            return Err(format!("{width}x{height} pixels, expected 1x1 to below a million"));
        }
        if let Some(f) = [fx, fy].iter().find(|f| !(1e-3..1e7).contains(*f)) {
            return Err(format!("its focal length is {f}, expected pixels above 0"));
        }
        if let Some(c) = [cx, cy].iter().find(|c| !(-1e6..1e6).contains(*c)) {
            return Err(format!("its principal point is at {c}, expected pixels"));
        }
        let is_large = |k: &&f64| !(-1e6..1e6).contains(*k);
        if let Some(k) = lens.coefficients().iter().find(is_large) {
            return Err(format!("a lens coefficient is {k}, expected a small one"));
        }
        let focal = [fx, fy].map(|f| Some(Focal::Pixels(f)));
        // Images of a camera may have been made smaller by different factors.
        Ok(Self { size: Some(size), focal, center: [cx, cy].map(Some), shared: false })
    }

    /// Whether an image of this size has the shape that the file says; a side may be rounded by
    /// a pixel.
    pub(super) fn fits(&self, size: [u32; 2]) -> bool {
        let [width, height] = size.map(f64::from);
        let own = self.size.unwrap_or([width, height]);
        (width * own[1] - height * own[0]).abs() <= own[0].max(own[1])
    }

    /// The camera for an image of this size; `None` if that has another shape
    /// than the file says.
    pub(super) fn camera(&self, size: [u32; 2], pose: [f32; 16]) -> Option<Camera> {
        let [width, height] = size.map(f64::from);
        let own = self.size.unwrap_or([width, height]);
        if !self.fits(size) {
            return None;
        }
        let scale = [width / own[0], height / own[1]];
        let pixels = |a: usize| match self.focal[a] {
            Some(Focal::Angle(angle)) => Some(0.5 * own[a] / (0.5 * angle).tan()),
            Some(Focal::Pixels(pixels)) => Some(pixels),
            Some(Focal::Heights(heights)) => Some(heights * own[1]),
            Some(Focal::Panorama) => Some(own[a] / ([2.0, 1.0][a] * std::f64::consts::PI)),
            None => None,
        };
        let x = pixels(0).or(pixels(1))?;
        let y = pixels(1).unwrap_or(x);
        let center = [0, 1].map(|a| (self.center[a].unwrap_or(0.5 * own[a]) * scale[a]) as f32);
        let focal = [(x * scale[0]) as f32, (y * scale[1]) as f32];
        let [width, height] = size;
        Some(Camera { width, height, focal, center, camera_to_world: pose })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_images_of_one_shape() {
        let intrinsics = Intrinsics {
            size: Some([1081.0, 1921.0]),
            focal: [Some(Focal::Pixels(1000.0)), None],
            center: [Some(540.0), None],
            shared: true,
        };
        let camera = intrinsics.camera([270, 480], [0.0; 16]).unwrap();
        assert!((camera.focal[0] - 1000.0 * 270.0 / 1081.0).abs() < 1e-3);
        assert!((camera.focal[1] - 1000.0 * 480.0 / 1921.0).abs() < 1e-3);
        assert!((camera.center[0] - 540.0 * 270.0 / 1081.0).abs() < 1e-3);
        assert_eq!(camera.center[1], 240.0);
        assert_eq!(intrinsics.camera([480, 270], [0.0; 16]), None);
        assert_eq!(intrinsics.camera([270, 400], [0.0; 16]), None);
    }

    #[test]
    fn a_field_of_view_is_that_of_any_image() {
        let intrinsics = Intrinsics::from_fov_x(std::f64::consts::FRAC_PI_2);
        let camera = intrinsics.camera([4, 2], [0.0; 16]).unwrap();
        assert!((camera.focal[0] - 2.0).abs() < 1e-6 && (camera.focal[1] - 2.0).abs() < 1e-6);
        assert_eq!(camera.center, [2.0, 1.0]);
    }
}
