//! Products of what planes and lines hold at a point.

use pocketnerf_formats::import::volume::Factors;

/// The entry below a grid position, of those that have a next one, and how far the position is
/// beyond it.
pub(super) fn between(position: f32, entries: usize) -> (usize, f32) {
    let below = (position.max(0.0) as usize).min(entries - 2);
    (below, (position - below as f32).clamp(0.0, 1.0))
}

/// Between which entries of a grid a point lies, along x, y and z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place([(usize, f32); 3]);

impl Place {
    /// Of a point within a box on whose faces the outermost entries lie.
    pub(super) fn of(point: [f32; 3], [low, high]: [[f32; 3]; 2], sizes: [usize; 3]) -> Self {
        Self([0, 1, 2].map(|a| {
            let unit = (point[a] - low[a]) / (high[a] - low[a]);
            between(unit * (sizes[a] - 1) as f32, sizes[a])
        }))
    }
}

/// Writes the products at a place of a grid of these sizes: those of plane 0 and its line, then of
/// 1 and 2; of lines alone, of all three.
pub(super) fn products(factors: &Factors, place: Place, sizes: [usize; 3], out: &mut [f32]) {
    let mut first = 0;
    for i in 0..3 {
        let n = factors.components[i];
        let out = match factors.planes {
            Some(_) => &mut out[first..first + n],
            None => &mut out[..n],
        };
        let (entry, beyond) = place.0[Factors::line_axis(i)];
        let line = &factors.lines[i][n * entry..][..2 * n];
        let (low, high) = line.split_at(n);
        let along = low.iter().zip(high).map(|(low, high)| low + beyond * (high - low));
        match &factors.planes {
            Some(planes) => {
                let [column, row] = Factors::plane_axes(i);
                let width = sizes[column];
                let (x, right) = place.0[column];
                let (y, up) = place.0[row];
                let rows = [y, y + 1].map(|y| &planes[i][n * (y * width + x)..][..2 * n]);
                let weights = [
                    (1.0 - up) * (1.0 - right),
                    (1.0 - up) * right,
                    up * (1.0 - right),
                    up * right,
                ];
                let corners = [&rows[0][..n], &rows[0][n..], &rows[1][..n], &rows[1][n..]];
                for (c, (out, along)) in out.iter_mut().zip(along).enumerate() {
                    let across: f32 = (0..4).map(|k| weights[k] * corners[k][c]).sum();
                    *out = across * along;
                }
                first += n;
            }
            None if i == 0 => out.iter_mut().zip(along).for_each(|(out, along)| *out = along),
            None => out.iter_mut().zip(along).for_each(|(out, along)| *out *= along),
        }
    }
}
