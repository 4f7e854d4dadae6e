//! The error-weighted pixel sampler: rays where the error is.
//!
//! The variance of a step's gradient is smallest where pixels are drawn in proportion
//! to the size of their gradient, about the root of their squared error, and weighed
//! by one over that: on average the gradient stays that of all pixels alike
//! (importance sampling; for fields, Kheradmand et al. 2024).

use crate::random::Random;
use crate::trainer::pixels::alias_table::AliasTable;

/// Squared error a channel that is expected where nothing is known yet: much.
pub(crate) const UNKNOWN: f32 = 0.05;
/// How much the newest pixel counts in its tile's error.
const NEWEST: f32 = 0.25;
/// Part of the mean error that is added to all: no tile is forgotten, and no pixel
/// weighs more than a few times as much as others.
const FLOOR: f32 = 0.1;
/// So much is added where there is no error at all.
const LEAST: f32 = 1e-9;

/// How often the tiles of the views are drawn.
#[derive(Clone, Debug)]
pub(crate) struct PixelSampler {
    /// Mean squared error of each tile's latest pixels.
    errors: Vec<f32>,
    /// How often each is drawn, 1 on average.
    sizes: Vec<f32>,
    /// Which are never drawn; empty: all are.
    left_out: Vec<bool>,
    alias: AliasTable,
    /// How often that has changed.
    changes: u32,
}

impl PixelSampler {
    /// All of so many tiles alike.
    pub(crate) fn new(n_tiles: usize) -> Self {
        let (errors, sizes) = (vec![UNKNOWN; n_tiles], vec![1.0; n_tiles]);
        let alias = AliasTable::uniform(n_tiles);
        Self { errors, sizes, left_out: Vec::new(), alias, changes: 0 }
    }

    /// From now on these are never drawn, and all others as before; none, if there is nothing
    /// else.
    pub(crate) fn leave_out(&mut self, which: impl Fn(usize) -> bool) {
        self.left_out = (0..self.errors.len()).map(which).collect();
        if !self.left_out.contains(&true) || !self.left_out.contains(&false) {
            self.left_out = Vec::new();
        }
        self.renew();
    }

    fn is_drawn(&self, tile: usize) -> bool {
        !self.left_out.get(tile).copied().unwrap_or(false)
    }

    /// The mean over the tiles that are drawn.
    fn mean(&self, values: &[f32]) -> f64 {
        let drawn = || (0..values.len()).filter(|tile| self.is_drawn(*tile));
        drawn().map(|tile| f64::from(values[tile])).sum::<f64>() / drawn().count().max(1) as f64
    }

    /// How often it has changed which tiles are drawn.
    #[cfg(feature = "gpu")]
    pub(crate) const fn changes(&self) -> u32 {
        self.changes
    }

    /// Draws tiles as often as their sizes say.
    fn renew(&mut self) {
        self.changes += 1;
        if self.left_out.is_empty() {
            return self.alias.update(&self.sizes);
        }
        // 1 on average over those that are drawn, and so over all.
        let all = self.sizes.len() as f64;
        let drawn = self.left_out.iter().filter(|out| !**out).count() as f64;
        let scale = (all / (drawn * self.mean(&self.sizes))) as f32;
        let size = |tile: usize| if self.is_drawn(tile) { scale * self.sizes[tile] } else { 0.0 };
        let sizes: Vec<f32> = (0..self.sizes.len()).map(size).collect();
        self.alias.update(&sizes);
    }

    /// A random tile, and what its pixels weigh.
    #[inline]
    pub(crate) fn draw(&self, random: &mut Random) -> (u32, f32) {
        let tile = self.alias.draw(random);
        (tile as u32, 1.0 / self.sizes[tile])
    }

    /// Notes the squared error a channel of a pixel.
    #[inline]
    pub(crate) fn note(&mut self, tile: u32, squared_error: f32) {
        let error = &mut self.errors[tile as usize];
        *error += NEWEST * (squared_error - *error);
    }

    /// From now on tiles are drawn as the errors say.
    pub(crate) fn update(&mut self) {
        let mean = self.mean(&self.errors);
        let added = FLOOR * mean as f32 + LEAST;
        for (size, error) in self.sizes.iter_mut().zip(&self.errors) {
            *size = (error + added).sqrt();
        }
        let scale = (1.0 / self.mean(&self.sizes)) as f32;
        self.sizes.iter_mut().for_each(|size| *size *= scale);
        self.renew();
    }

    /// Errors and sizes.
    pub(crate) fn state(&self) -> [&[f32]; 2] {
        [&self.errors, &self.sizes]
    }

    /// Restores such a state, one after the other; `false`, and nothing done, where it is
    /// not one.
    pub(crate) fn restore(&mut self, state: &[f32]) -> bool {
        let n = self.errors.len();
        if state.len() != 2 * n {
            return false;
        }
        let (errors, sizes) = state.split_at(n);
        let is_sound = errors.iter().all(|error| (0.0..f32::INFINITY).contains(error))
            && sizes.iter().all(|size| (f32::MIN_POSITIVE..f32::INFINITY).contains(size));
        if !is_sound {
            return false;
        }
        self.errors.copy_from_slice(errors);
        self.sizes.copy_from_slice(sizes);
        self.renew();
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_drawn_by_the_root_of_their_error() {
        let mut sampler = PixelSampler::new(4);
        let mut random = Random::new(1, [0; 3]);
        assert_eq!(sampler.draw(&mut random).1, 1.0);
        // Often enough to forget what was expected.
        for _ in 0..100 {
            for (tile, error) in [(0, 0.0), (1, 0.01), (2, 0.01), (3, 0.06)] {
                sampler.note(tile, error);
            }
        }
        sampler.update();
        // The mean is 0.02, a tenth is added: roots of 0.002, 0.012, 0.012, 0.062.
        let roots = [0.002f64, 0.012, 0.012, 0.062].map(f64::sqrt);
        let sum: f64 = roots.iter().sum();
        let (mut counts, mut weights) = ([0.0; 4], 0.0);
        for _ in 0..200_000 {
            let (tile, weight) = sampler.draw(&mut random);
            let expected = sum / (4.0 * roots[tile as usize]);
            assert!((f64::from(weight) / expected - 1.0).abs() < 1e-4, "{tile}: {weight}");
            counts[tile as usize] += 1.0 / 200_000.0;
            weights += f64::from(weight) / 200_000.0;
        }
        for (count, root) in counts.iter().zip(roots) {
            assert!(f64::abs(count - root / sum) < 0.005, "{counts:?}");
        }
        // Unbiased: weights are 1 on average.
        assert!((weights - 1.0).abs() < 0.01, "{weights}");
    }

    #[test]
    fn what_is_left_out_is_never_drawn() {
        let mut sampler = PixelSampler::new(5);
        sampler.leave_out(|tile| tile % 2 == 1);
        let mut random = Random::new(1, [0; 3]);
        let counts = |sampler: &PixelSampler, random: &mut Random| {
            let (mut counts, mut weights) = ([0.0; 5], 0.0);
            for _ in 0..60_000 {
                let (tile, weight) = sampler.draw(random);
                counts[tile as usize] += 1.0 / 60_000.0;
                weights += f64::from(weight) / 60_000.0;
            }
            assert!((weights - 1.0).abs() < 0.02, "{weights}");
            counts
        };
        let found = counts(&sampler, &mut random);
        assert!(found[1] == 0.0 && found[3] == 0.0, "{found:?}");
        assert!([0, 2, 4].iter().all(|i| f64::abs(found[*i] - 1.0 / 3.0) < 0.01), "{found:?}");
        // By their errors too, and resumed.
        for _ in 0..100 {
            (0..5).for_each(|tile| sampler.note(tile, [0.01, 9.0, 0.01, 9.0, 0.04][tile as usize]));
        }
        sampler.update();
        let found = counts(&sampler, &mut random);
        assert!(found[1] == 0.0 && found[3] == 0.0 && found[4] > 0.45, "{found:?}");
        let mut resumed = PixelSampler::new(5);
        resumed.leave_out(|tile| tile % 2 == 1);
        assert!(resumed.restore(&sampler.state().concat()));
        let (mut a, mut b) = (Random::new(3, [0; 3]), Random::new(3, [0; 3]));
        assert!((0..1000).all(|_| sampler.draw(&mut a) == resumed.draw(&mut b)));
        // They come back as often as was last known.
        sampler.leave_out(|_| false);
        let mut random = Random::new(5, [0; 3]);
        assert!((0..1000).any(|_| sampler.draw(&mut random).0 == 1));
    }

    #[test]
    fn a_state_is_gone_on_from() {
        let mut first = PixelSampler::new(100);
        (0..100).for_each(|tile| first.note(tile, tile as f32 * 1e-3));
        first.update();
        first.note(7, 0.5);
        let mut second = PixelSampler::new(100);
        assert!(second.restore(&first.state().concat()));
        let (mut a, mut b) = (Random::new(3, [0; 3]), Random::new(3, [0; 3]));
        assert!((0..1000).all(|_| first.draw(&mut a) == second.draw(&mut b)));
        assert_eq!(first.state(), second.state());
        // No error anywhere: all alike.
        let mut perfect = PixelSampler::new(2);
        assert!(perfect.restore(&[0.0, 0.0, 0.5, 1.5]));
        perfect.update();
        assert_eq!(perfect.state()[1], [1.0; 2]);
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            assert!(!perfect.restore(&[bad, 0.0, 1.0, 1.0]));
            assert!(!perfect.restore(&[0.0, 0.0, bad, 1.0]));
        }
        assert!(!perfect.restore(&[0.0, 0.0, 0.0, 1.0]) && !perfect.restore(&[1.0; 3]));
    }
}
