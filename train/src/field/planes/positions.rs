//! The gradient of points: back through the interpolation between entries of planes and lines.

use pocketnerf_core::encoding::planes::{ACROSS, FEATURES, Places};
use pocketnerf_core::lanes::LANES;

/// Adds the gradient through one pair of a plane and a line along `axis` to that of a multiple
/// of 16 `points`.
///
/// `rows` holds the gradient of the pair's products, `[FEATURES][stride]`.
#[inline(always)]
pub(super) fn add_pair(
    (plane, line, axis, resolution): (&[f32], &[f32], usize, u32),
    points: [&[f32]; 3],
    (rows, stride): (&[f32], usize),
    d_points: &mut [&mut [f32]; 3],
) {
    let [plane, line] = [plane, line].map(|table| table.as_chunks::<FEATURES>().0);
    let [first, second] = ACROSS[axis];
    let scale = (resolution - 1) as f32;
    let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
    let mut places = Places::ZERO;
    for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
        places.find(resolution, [x, y, z]);
        for s in 0..LANES {
            let column = g * LANES + s;
            let entry = |behind: u32| &plane[(places.on_plane[axis][s] + behind) as usize];
            let corners = [entry(0), entry(1), entry(resolution), entry(resolution + 1)];
            let ends = [0, 1].map(|behind| &line[places.on_line[axis][s] as usize + behind]);
            let [along, a, b] =
                [axis, first, second].map(|axis| places.line_weights[axis].map(|w| w[s]));
            // What the product gains along the line, and along both axes of the plane.
            let mut gains = [0.0; 3];
            for v in 0..FEATURES {
                let row = rows[v * stride + column];
                let [p00, p10, p01, p11] = corners.map(|entry| entry[v]);
                let [low, high] = ends.map(|entry| entry[v]);
                let (near, far) = (a[0] * p00 + a[1] * p10, a[0] * p01 + a[1] * p11);
                gains[0] += row * (b[0] * near + b[1] * far) * (high - low);
                let on_line = row * (along[0] * low + along[1] * high);
                gains[1] += on_line * (b[0] * (p10 - p00) + b[1] * (p11 - p01));
                gains[2] += on_line * (far - near);
            }
            for (axis, gain) in [axis, first, second].into_iter().zip(gains) {
                d_points[axis][column] += scale * gain;
            }
        }
    }
}
