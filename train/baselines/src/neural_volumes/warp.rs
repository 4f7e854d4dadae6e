//! Where the template of a place is: a mixture of affine maps, whose weights are volumes of their
//! own.

use rayon::prelude::*;

use super::grid::{Between, Grid};
use crate::network::Real;

/// Parts of the field; sums of gradients follow their order.
const PARTS: usize = 4;
/// Keeps the division finite.
const EPSILON: f64 = 1e-6;
/// Numbers of an affine map.
pub(super) const AFFINE: usize = 12;

/// Affine maps, row after row, and the logarithms of their weights, a channel each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mixture<'m, T> {
    pub(super) maps: &'m [[T; AFFINE]],
    /// The weights themselves.
    pub(super) weights: &'m Grid<T>,
}

/// A map's place and weight.
#[derive(Clone, Copy)]
struct Mapped<T> {
    place: [T; 3],
    weight: T,
    between: Option<Between<T>>,
}

impl<T: Real> Mixture<'_, T> {
    #[inline]
    fn mapped(&self, i: usize, place: [T; 3]) -> Mapped<T> {
        let map = &self.maps[i];
        let row = |r: usize| {
            map[4 * r] * place[0]
                + map[4 * r + 1] * place[1]
                + map[4 * r + 2] * place[2]
                + map[4 * r + 3]
        };
        let place = [row(0), row(1), row(2)];
        let between = self.weights.find(place);
        let weight =
            between.map_or(T::zero(), |between| self.weights.values_at::<1>(&between, i)[0]);
        Mapped { place, weight, between }
    }

    /// Sum of all weights, and the mean place.
    #[inline]
    fn mean(&self, mapped: impl Iterator<Item = Mapped<T>>) -> (T, [T; 3]) {
        let (mut sum, mut mean) = (T::of(EPSILON), [T::zero(); 3]);
        for mapped in mapped {
            sum += mapped.weight;
            for (mean, place) in mean.iter_mut().zip(mapped.place) {
                *mean += mapped.weight * place;
            }
        }
        (sum, [mean[0] / sum, mean[1] / sum, mean[2] / sum])
    }

    /// The field: three channels, places of the template.
    pub(super) fn field(&self, side: usize) -> Grid<T> {
        let mut field = Grid::zeros(side, 3);
        let layer = side.pow(2) * 3;
        field.values.par_chunks_mut(layer).enumerate().for_each(|(z, values)| {
            for (i, value) in values.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let place = place([i % side, i / side, z], side);
                *value = self.mean((0..self.maps.len()).map(|i| self.mapped(i, place))).1;
            }
        });
        field
    }

    /// From the field's gradient to those of maps and weights.
    pub(super) fn backward(&self, d: &Grid<T>) -> (Vec<[T; AFFINE]>, Grid<T>) {
        let side = d.side;
        let layers = side.div_ceil(PARTS);
        let parts = d.values.par_chunks(layers * side.pow(2) * 3).enumerate();
        let parts: Vec<_> = parts
            .map(|(part, d)| {
                let mut d_maps = vec![[T::zero(); AFFINE]; self.maps.len()];
                let mut d_weights = self.weights.empty();
                let first = part * layers * side.pow(2);
                for (d, i) in d.as_chunks::<3>().0.iter().zip(first..) {
                    if *d != [T::zero(); 3] {
                        let at = [i % side, i / side % side, i / side.pow(2)];
                        self.backward_at(place(at, side), *d, &mut d_maps, &mut d_weights);
                    }
                }
                (d_maps, d_weights)
            })
            .collect();
        let mut sums = (vec![[T::zero(); AFFINE]; self.maps.len()], self.weights.empty());
        for (maps, weights) in &parts {
            let all = sums.0.iter_mut().flatten().zip(maps.iter().flatten());
            all.for_each(|(sum, d)| *sum += *d);
            sums.1.add_grid(weights);
        }
        sums
    }

    fn backward_at(
        &self,
        place: [T; 3],
        d: [T; 3],
        d_maps: &mut [[T; AFFINE]],
        d_weights: &mut Grid<T>,
    ) {
        let all: Vec<Mapped<T>> = (0..self.maps.len()).map(|i| self.mapped(i, place)).collect();
        let (sum, mean) = self.mean(all.iter().copied());
        for (i, (d_map, mapped)) in d_maps.iter_mut().zip(all).enumerate() {
            let Some(between) = mapped.between else { continue };
            let d_weight: T = (0..3).map(|a| d[a] * (mapped.place[a] - mean[a])).sum::<T>() / sum;
            d_weights.add(&between, i, [d_weight]);
            let slope = self.weights.slope(&between, i, [d_weight]);
            for a in 0..3 {
                let d_place = d[a] * mapped.weight / sum + slope[a];
                for b in 0..3 {
                    d_map[4 * a + b] += d_place * place[b];
                }
                d_map[4 * a + 3] += d_place;
            }
        }
    }
}

/// The place of a point of a cube.
fn place<T: Real>(at: [usize; 3], side: usize) -> [T; 3] {
    at.map(|at| T::of(2.0 * at as f64 / (side - 1) as f64 - 1.0))
}
