//! The gradient of points: back through the interpolation between entries of planes and lines.

use std::array::from_fn;

use pocketnerf_core::encoding::planes::{ACROSS, FEATURES, Places};
use pocketnerf_core::lanes::LANES;

/// Slopes are measured across so many distances, the last one that between neighbours.
pub(super) const LEVELS: usize = 5;
/// The longest is this share of the box.
const LONGEST: f32 = 1.0 / 16.0;

/// Entries across which slopes are measured, with the share of each such slope in the gradient: a
/// level gives way to the next one as that begins to count.
pub(super) fn reaches(resolution: u32, levels: &[f32]) -> impl Iterator<Item = (u32, f32)> {
    let shares: [f32; LEVELS] = from_fn(|level| levels.get(level).copied().unwrap_or(0.0));
    let reach = move |level: usize| {
        let entries = LONGEST * (resolution - 1) as f32 * 0.5f32.powi(level as i32);
        if level + 1 == LEVELS { 1 } else { (entries.round() as u32).max(1) }
    };
    let share = move |level| shares[level] - shares.get(level + 1).copied().unwrap_or(0.0);
    (0..LEVELS).map(move |level| (reach(level), share(level))).filter(|(_, share)| *share > 0.0)
}

/// Adds the gradient through one pair of a plane and a line along `axis` to that of a multiple
/// of 16 `points`: slopes across `reach` entries, times a share.
///
/// `rows` holds the gradient of the pair's products, `[FEATURES][stride]`.
#[inline(always)]
pub(super) fn add_pair(
    (plane, line, axis, resolution): (&[f32], &[f32], usize, u32),
    points: [&[f32]; 3],
    (rows, stride): (&[f32], usize),
    (reach, share): (u32, f32),
    d_points: &mut [&mut [f32]; 3],
) {
    let [plane, line] = [plane, line].map(|table| table.as_chunks::<FEATURES>().0);
    let axes = [axis, ACROSS[axis][0], ACROSS[axis][1]];
    let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
    let mut places = Places::ZERO;
    for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
        places.find(resolution, [x, y, z]);
        for s in 0..LANES {
            let column = g * LANES + s;
            // Along the line, and along both axes of the plane.
            let cell = axes.map(|axis| places.on_line[axis][s]);
            let weights = axes.map(|axis| places.line_weights[axis].map(|w| w[s]));
            let low = cell.map(|cell| cell.saturating_sub((reach - 1) / 2));
            let high = cell.map(|cell| (cell + 1 + reach / 2).min(resolution - 1));
            let on_plane = |a: u32, b: u32| &plane[(a + resolution * b) as usize];
            let [line_low, line_high] = [low, high].map(|end| &line[end[0] as usize]);
            let line_near = [0, 1].map(|behind| &line[cell[0] as usize + behind]);
            let rows_low = [0, 1].map(|behind| on_plane(low[1], cell[2] + behind));
            let rows_high = [0, 1].map(|behind| on_plane(high[1], cell[2] + behind));
            let columns_low = [0, 1].map(|behind| on_plane(cell[1] + behind, low[2]));
            let columns_high = [0, 1].map(|behind| on_plane(cell[1] + behind, high[2]));
            let near = [0, 1].map(|behind| on_plane(cell[1], cell[2] + behind));
            let far = [0, 1].map(|behind| on_plane(cell[1] + 1, cell[2] + behind));
            let [along, a, b] = weights;
            let mut gains = [0.0; 3];
            for v in 0..FEATURES {
                let row = rows[v * stride + column];
                let blend = |ends: [&[f32; FEATURES]; 2], w: [f32; 2]| {
                    w[0] * ends[0][v] + w[1] * ends[1][v]
                };
                let of_plane = row * (a[0] * blend(near, b) + a[1] * blend(far, b));
                let of_line = row * blend(line_near, along);
                gains[0] += of_plane * (line_high[v] - line_low[v]);
                gains[1] += of_line * (blend(rows_high, b) - blend(rows_low, b));
                gains[2] += of_line * (blend(columns_high, a) - blend(columns_low, a));
            }
            let scale = share * (resolution - 1) as f32;
            for (i, axis) in axes.into_iter().enumerate() {
                d_points[axis][column] += scale * gains[i] / (high[i] - low[i]) as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_grow_finer_one_after_the_other() {
        let of = |levels: &[f32]| reaches(300, levels).collect::<Vec<_>>();
        assert_eq!(of(&[1.0, 0.0, 0.0]), [(19, 1.0)]);
        assert_eq!(of(&[1.0, 1.0, 0.25]), [(9, 0.75), (5, 0.25)]);
        assert_eq!(of(&[1.0; 16]), [(1, 1.0)]);
        assert_eq!(reaches(17, &[1.0, 0.5]).collect::<Vec<_>>(), [(1, 0.5), (1, 0.5)]);
    }

    /// Of products that are the square of a coordinate times others, across several entries and
    /// at the walls.
    #[test]
    fn slopes_are_those_of_chords() {
        const N: u32 = 33;
        let at = |i: u32| i as f32 / (N - 1) as f32;
        let line: Vec<f32> = (0..N).flat_map(|i| [at(i) * at(i); FEATURES]).collect();
        let plane = (0..N * N).flat_map(|e| [(1.0 + at(e % N)) * (2.0 - at(e / N)); FEATURES]);
        let plane: Vec<f32> = plane.collect();
        let points = [[0.0, 0.5, 1.0], [0.25, 0.0, 0.75], [0.5, 1.0, 0.125]];
        let rows = [0.125; FEATURES * LANES];
        for (reach, [before, behind]) in [(1, [0, 1]), (4, [1, 3]), (5, [2, 3])] {
            let mut padded = [[0.0; LANES]; 3];
            for (p, point) in points.iter().enumerate() {
                (0..3).for_each(|axis| padded[axis][p] = point[axis]);
            }
            let mut found = [[0.0; LANES]; 3];
            let [x, y, z] = &mut found;
            let shape = (&plane[..], &line[..], 0, N);
            let to = &mut [&mut x[..], &mut y[..], &mut z[..]];
            add_pair(shape, padded.each_ref().map(|p| &p[..]), (&rows, LANES), (reach, 2.0), to);
            for (p, [u, a, b]) in points.into_iter().enumerate() {
                let cell = ((u * (N - 1) as f32) as u32).min(N - 2);
                let ends = [cell.saturating_sub(before), (cell + behind).min(N - 1)].map(at);
                // (v² - u²) / (v - u).
                let plane = (1.0 + a) * (2.0 - b);
                let expected = [(ends[0] + ends[1]) * plane, u * u * (2.0 - b), -u * u * (1.0 + a)];
                for axis in 0..3 {
                    let found = found[axis][p];
                    assert!((found - 2.0 * expected[axis]).abs() < 1e-4, "{reach} {axis} {found}");
                }
            }
        }
    }
}
