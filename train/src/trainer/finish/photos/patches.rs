//! Parts of a view that are looked at.

use pocketnerf_core::Camera;

use crate::metrics::composite_on;
use crate::trainer::pixels::rays::{Pixel, RaySource};

/// Parts along a side of a view.
const PARTS: u32 = 4;
/// Pixels along a side of a part, at most.
const SIDE: u32 = 32;

/// The cameras of a view's parts, evenly spread, and the pixel where each begins.
pub(super) fn patches(camera: &Camera) -> impl Iterator<Item = (Camera, [u32; 2])> {
    let camera = *camera;
    let cell = [camera.width, camera.height].map(|side| (side / PARTS).max(1));
    let size = cell.map(|side| side.min(SIDE));
    (0..PARTS * PARTS).map(move |i| {
        let at = [i % PARTS, i / PARTS];
        let corner = [0, 1].map(|a| cell[a] * at[a] + (cell[a] - size[a]) / 2);
        let center = [0, 1].map(|a| camera.center[a] - corner[a] as f32);
        (Camera { width: size[0], height: size[1], center, ..camera }, corner)
    })
}

/// What a photograph shows there, over a background; NaN where a pixel does not count.
pub(super) fn crop(
    source: &RaySource,
    view: usize,
    (camera, corner): &(Camera, [u32; 2]),
    background: [f32; 3],
) -> Vec<f32> {
    let width = source.cameras()[view].width;
    let pixels = (0..camera.height).flat_map(|y| (0..camera.width).map(move |x| (x, y)));
    let mut photo = Vec::with_capacity((3 * camera.width * camera.height) as usize);
    for (x, y) in pixels {
        let (x, y) = (x + corner[0], y + corner[1]);
        let counts = source.is_exact(view, (y * width + x) as usize);
        let rgb = composite_on(&source.rgba(Pixel { view: view as u32, x, y }), background);
        photo.extend(rgb.into_iter().map(|value| if counts { value } else { f32::NAN }));
    }
    photo
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_parts_of_the_picture() {
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let whole = Camera::from_fov_x(200, 100, 0.7, pose);
        let parts: Vec<_> = patches(&whole).collect();
        assert_eq!(parts.len(), 16);
        for (i, (part, [x, y])) in parts.into_iter().enumerate() {
            assert_eq!([part.width, part.height], [SIDE, 25]);
            let (here, there) = (part.ray(3.5, 7.5), whole.ray(x as f32 + 3.5, y as f32 + 7.5));
            let off = glam::Vec3::from(here.direction) - glam::Vec3::from(there.direction);
            assert!(off.length() < 1e-6);
            // Nine pixels on either side of 32 of 50; rows leave none.
            assert_eq!([x, y], [50 * (i as u32 % 4) + 9, 25 * (i as u32 / 4)]);
        }
    }
}
