//! The space of a forward-facing capture, from its cameras.

use pocketnerf_core::space::Ndc;
use pocketnerf_core::{Camera, Space};

use crate::dataset::View;

/// Points along each edge of an image that tell what its camera sees: a lens bends edges.
const POINTS: u32 = 16;

/// Normalised device coordinates for cameras that look along -z, more or less, of
/// scenes beyond the plane z = -`near` (scene units), with a box that holds all the
/// cameras see. `None` where there is no camera, or one sees something that does not
/// lie forwards.
#[must_use]
pub fn ndc_of(views: &[View], near: f32) -> Option<Ndc> {
    let mean = |of: fn(&Camera) -> f32| {
        views.iter().map(|view| of(&view.camera)).sum::<f32>() / views.len() as f32
    };
    let slope =
        [mean(|c| 2.0 * c.focal[0] / c.width as f32), mean(|c| 2.0 * c.focal[1] / c.height as f32)];
    // From the near plane to infinity.
    let mut ndc = Ndc { near, slope, min: [0.0, 0.0, -1.0], max: [0.0, 0.0, 1.0] };
    let space = Space::Ndc(ndc);
    for view in views {
        let (width, height) = (view.camera.width as f32, view.camera.height as f32);
        let along = (0..=POINTS).map(|i| i as f32 / POINTS as f32);
        let edges = along.flat_map(|s| [[s, 0.0], [s, 1.0], [0.0, s], [1.0, s]]);
        for [x, y] in edges {
            let local = space.local(&view.ray(x * width, y * height))?;
            let way = (1.0 - local.origin[2]) / local.direction[2];
            for a in 0..2 {
                for at in [local.origin[a], local.origin[a] + way * local.direction[a]] {
                    ndc.min[a] = ndc.min[a].min(at);
                    ndc.max[a] = ndc.max[a].max(at);
                }
            }
        }
    }
    Space::Ndc(ndc).validate().is_ok().then_some(ndc)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 90° wide, as high, at a place and turned by as much to the right.
    fn view(position: [f32; 3], turned: f32) -> View {
        let ahead = [position[0] + turned.sin(), position[1], position[2] - turned.cos()];
        let pose = Camera::look_at(position, ahead, [0.0, 1.0, 0.0]);
        let camera = Camera::from_fov_x(4, 4, std::f32::consts::FRAC_PI_2, pose);
        View::new("", camera, vec![255; 64])
    }

    #[test]
    fn the_box_holds_what_the_cameras_see() {
        // The near plane at 2, cameras at its half: x = -0.5 and 1 there see x from -2.5
        // to 3 at the plane, that is -1.25 to 1.5 of its half width; 0.5 below the axis,
        // y from -2.5 to 2: -1.25 to 1.
        let views = [view([-0.5, 0.0, 0.0], 0.0), view([1.0, -0.5, 0.0], 0.0)];
        let ndc = ndc_of(&views, 2.0).unwrap();
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
        assert_eq!(ndc.near, 2.0);
        assert!((ndc.slope[0] - 1.0).abs() < 1e-5 && (ndc.slope[1] - 1.0).abs() < 1e-5);
        assert!(near(ndc.min, [-1.25, -1.25, -1.0]), "{ndc:?}");
        assert!(near(ndc.max, [1.5, 1.0, 1.0]), "{ndc:?}");
        // Turned by atan(1/3), the right edge goes to tan(45° + that) = 2 at infinity.
        let turned = ndc_of(&[view([0.0; 3], (1.0f32 / 3.0).atan())], 1.0).unwrap();
        assert!((turned.max[0] - 2.0).abs() < 1e-5, "{turned:?}");
        // Turned by more than 45°, it sees what does not lie forwards.
        assert_eq!(ndc_of(&[view([0.0; 3], 0.8)], 1.0), None);
        assert_eq!(ndc_of(&[], 1.0), None);
        assert_eq!(ndc_of(&views, 0.0), None);
    }
}
