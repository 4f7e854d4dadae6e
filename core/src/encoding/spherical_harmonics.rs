//! Real spherical harmonics of a unit direction, as in instant-ngp.

use core::ops::{Add, Mul, Sub};

/// Highest degree: 16 values.
pub const MAX_DEGREE: u32 = 4;

/// Values of a given degree (1 to 4): degree 1 is the constant alone, which
/// makes a field independent of the view.
#[must_use]
pub const fn n_output(degree: u32) -> usize {
    (degree * degree) as usize
}

/// Writes the first `degree²` harmonics of the unit vector `d` to `out`.
///
/// `out` holds at least `degree²` values; `degree` is 1 to 4.
#[inline(always)]
pub fn evaluate(degree: u32, d: [f32; 3], out: &mut [f32]) {
    evaluate_each(degree, d, 1.0, out);
}

/// The same of one direction, or of one in every lane, or of whatever else is added and
/// multiplied; `one` is 1.
#[inline(always)]
pub fn evaluate_each<V>(degree: u32, [x, y, z]: [V; 3], one: V, out: &mut [V])
where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<Output = V> + Mul<f32, Output = V>,
{
    out[0] = one * 0.282_094_79;
    if degree < 2 {
        return;
    }
    out[1] = y * -0.488_602_51;
    out[2] = z * 0.488_602_51;
    out[3] = x * -0.488_602_51;
    if degree < 3 {
        return;
    }
    let (xx, yy, zz) = (x * x, y * y, z * z);
    out[4] = x * 1.092_548_4 * y;
    out[5] = y * -1.092_548_4 * z;
    out[6] = zz * 0.946_174_7 - one * 0.315_391_57;
    out[7] = x * -1.092_548_4 * z;
    out[8] = (xx - yy) * 0.546_274_2;
    if degree < 4 {
        return;
    }
    out[9] = y * 0.590_043_6 * (yy - xx * 3.0);
    out[10] = x * 2.890_611_4 * y * z;
    out[11] = y * 0.457_045_8 * (one - zz * 5.0);
    out[12] = z * 0.373_176_34 * (zz * 5.0 - one * 3.0);
    out[13] = x * 0.457_045_8 * (one - zz * 5.0);
    out[14] = z * 1.445_305_7 * (xx - yy);
    out[15] = x * 0.590_043_6 * (yy * 3.0 - xx);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orthonormal_over_the_sphere() {
        // Midpoint rule over (cos θ, φ): the Gram matrix must be the identity.
        let (n, m) = (200, 400);
        let mut gram = [[0.0f64; 16]; 16];
        for i in 0..n {
            let z = -1.0 + (2 * i + 1) as f32 / n as f32;
            let r = crate::math::sqrt(1.0 - z * z);
            for j in 0..m {
                let phi = (j as f32 + 0.5) / m as f32 * core::f32::consts::TAU;
                let mut y = [0.0; 16];
                evaluate(4, [r * crate::math::cos(phi), r * crate::math::sin(phi), z], &mut y);
                for a in 0..16 {
                    for b in 0..16 {
                        gram[a][b] += f64::from(y[a]) * f64::from(y[b]);
                    }
                }
            }
        }
        let area = 4.0 * core::f64::consts::PI / f64::from(n * m);
        for (a, row) in gram.iter().enumerate() {
            for (b, value) in row.iter().enumerate() {
                let expected = if a == b { 1.0 } else { 0.0 };
                assert!((value * area - expected).abs() < 2e-3, "{a} {b} {}", value * area);
            }
        }
    }
}
