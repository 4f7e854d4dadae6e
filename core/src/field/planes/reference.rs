//! Planes and lines, entry by entry, from the text of [`crate::encoding::planes`].

use crate::TensorView;
use crate::encoding::Planes;
use crate::field::{Features, PlanesField, ReferenceField};
use crate::reference::field::decode;
use crate::reference::network::{MAX_WIDTH, Values};

/// Values of an entry.
const FEATURES: usize = 8;

impl ReferenceField for PlanesField<'_> {
    fn reference(&self, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
        decode(&self.decoder, &encode(&self.planes, u), direction)
    }
}

/// Encodes unit point `u`: the components along x, then along y, along z.
fn encode(planes: &Planes<'_>, u: [f32; 3]) -> Values {
    let n = planes.resolution as usize;
    let [x, y, z] = u.map(|v| f64::from(v).clamp(0.0, 1.0) * (n - 1) as f64);
    let mut out = [0.0; MAX_WIDTH];
    for (axis, [along, first, second]) in [[x, y, z], [y, x, z], [z, x, y]].into_iter().enumerate()
    {
        for component in 0..planes.n_components as usize {
            let number = axis * planes.n_components as usize + component;
            let (pair, feature) = (&planes.pairs[number / FEATURES], number % FEATURES);
            let value =
                |table: &TensorView<'_>, e: usize| f64::from(table.get(e * FEATURES + feature));
            let row = |r: usize| interpolated(first, n, |i| value(&pair.plane, i + n * r));
            let on_plane = interpolated(second, n, row);
            let on_line = interpolated(along, n, |i| value(&pair.line, i));
            out[number] = on_plane * on_line;
        }
    }
    out
}

/// Between the entries around a position.
fn interpolated(position: f64, n: usize, entry: impl Fn(usize) -> f64) -> f64 {
    let low = (position as usize).min(n - 2);
    let fraction = position - low as f64;
    entry(low) * (1.0 - fraction) + entry(low + 1) * fraction
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encoding::planes::{MAX_PAIRS, Pair};
    use crate::reference::testing::tensor;

    #[test]
    fn products_by_hand() {
        // Three entries along an axis: u lies at 2 u. Feature 3 of the second pair along y: its
        // plane across y has 8 at (x, z) = (1, 2), its line 10 at y = 1 and 20 at y = 2.
        let mut pairs = [Pair::EMPTY; MAX_PAIRS];
        for (number, pair) in pairs.iter_mut().enumerate().take(6) {
            let (mut plane, mut line) = ([0.0; 9 * 8], [0.0; 3 * 8]);
            if number == 3 {
                plane[(1 + 3 * 2) * 8 + 3] = 8.0;
                (line[8 + 3], line[2 * 8 + 3]) = (10.0, 20.0);
            }
            *pair = Pair { plane: tensor(9, 8, &plane), line: tensor(3, 8, &line) };
        }
        let planes = Planes { resolution: 3, n_components: 16, pairs };
        planes.validate().unwrap();
        let at = |u| encode(&planes, u);
        // Component 16 + 8 + 3.
        assert_eq!(at([0.5, 0.5, 1.0])[27], 80.0);
        // Halfway along the line; three quarters of the plane's weight along x.
        assert_eq!(at([0.375, 0.75, 1.0])[27], 0.75 * 8.0 * 15.0);
        // Outside counts as on the face.
        assert_eq!(at([0.5, 2.0, 9.0])[27], 160.0);
        let others = at([0.5, 0.5, 1.0]).iter().filter(|value| **value != 0.0).count();
        assert_eq!(others, 1);
    }
}
