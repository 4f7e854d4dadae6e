//! How fine a picture is: the energy of a patch by spatial frequency.

use pocketnerf_core::math;

/// Mean squared deviation from the mean of an N × N patch: the part at spatial
/// frequencies (length of the frequency vector) above a quarter cycle per
/// pixel, and all of it.
pub(super) fn energy<const N: usize>(patch: &[[f64; N]; N]) -> (f64, f64) {
    let rows = patch.map(|row| transform(&row.map(|x| (x, 0.0))));
    let columns = (0..N).map(|k| transform(&rows.map(|row| row[k])));
    let (mut fine, mut all) = (0.0, 0.0);
    for (k, column) in columns.enumerate() {
        for (l, (re, im)) in column.into_iter().enumerate() {
            let power = (re * re + im * im) / (N * N * N * N) as f64;
            let [u, v] = [k, l].map(|f| f.min(N - f) as f64 / N as f64);
            if k + l > 0 {
                all += power;
            }
            if u * u + v * v > 0.25 * 0.25 {
                fine += power;
            }
        }
    }
    (fine, all)
}

/// The discrete Fourier transform of complex numbers (real, imaginary).
fn transform<const N: usize>(values: &[(f64, f64); N]) -> [(f64, f64); N] {
    core::array::from_fn(|k| {
        values.iter().enumerate().fold((0.0, 0.0), |sum, (x, (re, im))| {
            let (s, c) = math::sin_cos(core::f32::consts::TAU * (k * x % N) as f32 / N as f32);
            let (s, c) = (f64::from(s), f64::from(c));
            (sum.0 + re * c + im * s, sum.1 + im * c - re * s)
        })
    })
}

/// A sum of two waves has the energy of each, on its own side of the limit.
#[test]
fn waves_fall_on_their_side() {
    const N: usize = 16;
    let wave = |turns: usize| math::cos(core::f32::consts::TAU * turns as f32 / N as f32);
    // 6/16 cycle per pixel along y, amplitude 0.5; 2/16 along x, amplitude 1.
    let patch = core::array::from_fn(|y| {
        core::array::from_fn(|x| f64::from(0.3 + 0.5 * wave(6 * y % N) + wave(2 * x % N)))
    });
    let (fine, all) = energy::<N>(&patch);
    assert!((fine - 0.125).abs() < 1e-6 && (all - 0.625).abs() < 1e-6, "{fine} of {all}");
}
