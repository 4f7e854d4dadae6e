//! The loss of a batch of rays and of the volume, and its gradient.

use rayon::prelude::*;

use super::grid::Grid;
use super::march::Volume;
use crate::network::Real;
use crate::photographs::{Batch, Place};

/// Parts of a batch; sums of gradients follow their order.
const PARTS: usize = 4;
/// Weight of the prior that rays are opaque or transparent.
const DECIDED: f64 = 1e-3;
/// Weight of the total variation of the logarithm of opacities.
const SMOOTH: f64 = 1e-3;
/// The loss of a batch, its mean squared error, and the volume's gradient.
pub(super) fn loss<T: Real>(
    volume: &Volume<T>,
    place: &Place,
    batch: &Batch,
    offset: impl Fn(usize) -> f32 + Sync,
) -> (T, f64, Volume<T>) {
    let n = batch.rays.len();
    let part = n.div_ceil(PARTS);
    let background = place.background.map(|c| T::of(f64::from(c)));
    let weight = T::of(1.0 / n as f64);
    let third = T::of(1.0 / 3.0);
    let parts = batch.rays.par_chunks(part).zip(batch.colors.par_chunks(part)).enumerate();
    let parts: Vec<(T, f64, Volume<T>)> = parts
        .map(|(p, (rays, colors))| {
            let (mut loss, mut error, mut sums) = (T::zero(), 0.0, volume.empty());
            for (i, (ray, color)) in rays.iter().zip(colors).enumerate() {
                let pass = volume.march(place, ray, offset(p * part + i));
                let alpha = pass.rgba[3];
                let mut d = [T::zero(); 4];
                for c in 0..3 {
                    let off = pass.rgba[c] + (T::one() - alpha) * background[c]
                        - T::of(f64::from(color[c]));
                    loss += off * off * third * weight;
                    error += (off * off).value();
                    d[c] = (off + off) * third * weight;
                    d[3] -= d[c] * background[c];
                }
                let tenth = T::of(0.1);
                let [full, empty] = [alpha + tenth, T::one() - alpha + tenth];
                loss += T::of(DECIDED) * weight * (full.ln() + empty.ln());
                d[3] += T::of(DECIDED) * weight * (full.recip() - empty.recip());
                volume.backward(&pass, d, &mut sums);
            }
            (loss, error, sums)
        })
        .collect();
    let (mut total, mut error, mut sums) = (T::zero(), 0.0, volume.empty());
    for (loss, part, d) in parts {
        total += loss;
        error += part;
        sums.template.add_grid(&d.template);
        sums.warp.add_grid(&d.warp);
    }
    total += smoothness(&volume.template, &mut sums.template);
    (total, error / (3 * n) as f64, sums)
}

/// Total variation of the logarithm of opacities: its value; its gradient is added.
fn smoothness<T: Real>(template: &Grid<T>, d: &mut Grid<T>) -> T {
    let side = template.side;
    let weight = T::of(SMOOTH / side.pow(3) as f64);
    let floor = T::of(0.1);
    let opacities = template.values.par_chunks(4).map(|value| value[3] + floor);
    let opacities: Vec<T> = opacities.collect();
    let logarithms: Vec<T> = opacities.par_iter().map(|opacity| opacity.ln()).collect();
    let layers = d.values.par_chunks_mut(4 * side.pow(2)).enumerate();
    let sums = layers.map(|(z, layer)| {
        let mut sum = T::zero();
        for (at, d) in layer.chunks_mut(4).enumerate() {
            let i = z * side.pow(2) + at;
            for (along, stride) in [(at % side, 1), (at / side, side), (z, side.pow(2))] {
                // Differences from both neighbours; each one's value is counted once.
                if along > 0 {
                    let off = logarithms[i] - logarithms[i - stride];
                    d[3] += weight * (off + off) / opacities[i];
                    sum += off * off;
                }
                if along + 1 < side {
                    let off = logarithms[i] - logarithms[i + stride];
                    d[3] += weight * (off + off) / opacities[i];
                }
            }
        }
        sum
    });
    weight * sums.collect::<Vec<T>>().into_iter().sum()
}
