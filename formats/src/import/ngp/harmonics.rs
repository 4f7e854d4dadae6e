//! Real spherical harmonics in f64, and what they make of directions that are none.

use std::f64::consts::PI;

/// Values of degree 4.
pub(super) const HARMONICS: usize = 16;

/// The polynomials of the format's section 6, at any point.
fn harmonics([x, y, z]: [f64; 3]) -> [f64; HARMONICS] {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        0.28209479177387814,
        -0.48860251190291987 * y,
        0.48860251190291987 * z,
        -0.48860251190291987 * x,
        1.0925484305920792 * x * y,
        -1.0925484305920792 * y * z,
        0.9461746957575601 * zz - 0.31539156525252005,
        -1.0925484305920792 * x * z,
        0.5462742152960396 * (xx - yy),
        0.5900435899266435 * y * (yy - 3.0 * xx),
        2.890611442640554 * x * y * z,
        0.4570457994644658 * y * (1.0 - 5.0 * zz),
        0.3731763325901154 * z * (5.0 * zz - 3.0),
        0.4570457994644658 * x * (1.0 - 5.0 * zz),
        1.445305721320277 * z * (xx - yy),
        0.5900435899266435 * x * (3.0 * yy - xx),
    ]
}

/// nerfstudio's polynomials, which have no signs in front (as if x and y were turned over),
/// at (d + 1) / 2, as sums of the harmonics of d: row i belongs to value i.
///
/// Harmonics are orthonormal, so the integrals over the sphere of products of one of each
/// are the factors. The products have degree 6; four nodes of Gauss and Legendre along z
/// and eight angles around it are exact.
pub(super) fn of_half_directions() -> [[f64; HARMONICS]; HARMONICS] {
    const NODES: [[f64; 2]; 2] =
        [[0.3399810435848563, 0.6521451548625461], [0.8611363115940526, 0.3478548451374538]];
    let mut rows = [[0.0; HARMONICS]; HARMONICS];
    for [node, weight] in NODES {
        for (z, i) in [node, -node].into_iter().flat_map(|z| (0..8).map(move |i| (z, i))) {
            let ring = (1.0 - z * z).sqrt();
            let (sin, cos) = (f64::from(i) * PI / 4.0).sin_cos();
            let d = [ring * cos, ring * sin, z];
            let [x, y, z] = d.map(|d| 0.5 * (d + 1.0));
            let (halves, own) = (harmonics([-x, -y, z]), harmonics(d));
            for (row, half) in rows.iter_mut().zip(halves) {
                row.iter_mut()
                    .zip(own)
                    .for_each(|(sum, own)| *sum += weight * PI / 4.0 * half * own);
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_harmonics_are_the_polynomials() {
        let rows = of_half_directions();
        for d in [[0.6, 0.0, 0.8], [-0.48, 0.64, -0.6], [0.0, -1.0, 0.0]] {
            let own = harmonics(d);
            let [x, y, z] = d.map(|d| 0.5 * (d + 1.0));
            for (row, expected) in rows.iter().zip(harmonics([-x, -y, z])) {
                let found: f64 = row.iter().zip(own).map(|(a, b)| a * b).sum();
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
        // The constant by hand: 1 stays 1, and z becomes half of it and 1 / 2.
        let c = (3.0f64).sqrt() / 2.0;
        assert!((rows[0][0] - 1.0).abs() < 1e-12);
        assert!((rows[2][2] - 0.5).abs() < 1e-12 && (rows[2][0] - c).abs() < 1e-12);
    }
}
