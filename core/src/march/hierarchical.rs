//! Hierarchical sampling (Mildenhall et al. 2020, sections 4 and 5.2): evenly spaced
//! samples first, then more of them where the first have weight.
//!
//! The arithmetic is that of the authors' program, so that networks trained with it
//! see the same points.

use crate::march::{Hierarchical, Reach};
use crate::space::Piece;
use crate::{Ray, Space};

/// The part of a local ray that has samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Distance of the first.
    pub near: f32,
    /// Distance of the last.
    pub far: f32,
    /// Where the part of the ray that the last sample stands for ends.
    pub end: f32,
}

impl Hierarchical {
    /// Where along its [local](Space::local) ones a public ray has its samples; `None` where
    /// it has none. `near` and `far` are the model's, `stretch` is how much farther they are
    /// along the ray.
    #[must_use]
    pub fn extent(
        &self,
        space: &Space,
        ray: &Ray,
        [near, far]: [f32; 2],
        stretch: f32,
    ) -> Option<Extent> {
        let way = space.whole_way(ray);
        if self.reach == Reach::Clipped {
            let [near, far] = match way.filter(|_| space.is_bent()) {
                Some(way) => [near, far.min(way)],
                None => space.intersect(&space.local(ray)?, near, far)?,
            };
            return (near <= far).then_some(Extent { near, far, end: far });
        }
        let [near, far] = match way {
            Some(length) => [0.0, length],
            None if space.scene_box().is_none() => return None,
            None => [near, far].map(|distance| distance * stretch),
        };
        Some(Extent { near, far, end: ENDLESS })
    }
}

/// Local points along a public ray, at distances that do not decrease.
#[derive(Clone, Copy, Debug)]
pub struct Points<'s> {
    space: &'s Space,
    ray: Ray,
    piece: Option<Piece>,
}

impl<'s> Points<'s> {
    /// Along a ray that enters the space.
    #[must_use]
    pub fn new(space: &'s Space, ray: Ray) -> Self {
        Self { space, ray, piece: space.piece(&ray, 0.0) }
    }

    /// That at distance `t`: beyond the end of the ray, the last piece goes on.
    #[inline(always)]
    pub fn at(&mut self, t: f32) -> [f32; 3] {
        if self.piece.is_some_and(|piece| t >= piece.end) {
            self.piece = self.space.piece(&self.ray, t).or(self.piece);
        }
        let Some(Piece { local: Ray { origin: o, direction: d }, .. }) = self.piece else {
            return [f32::NAN; 3];
        };
        [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]
    }
}

/// Evenly spaced distances, the first at `near`, the last at `far`.
pub fn evenly(near: f32, far: f32, t: &mut [f32]) {
    let last = (t.len().max(2) - 1) as f32;
    for (i, t) in t.iter_mut().enumerate() {
        let along = i as f32 / last;
        *t = near * (1.0 - along) + far * along;
    }
}

/// Moves evenly spaced distances, each to anywhere nearer to it than to its neighbours
/// (stratified sampling, equation 2). `uniform` draws from 0 to 1.
pub fn jitter(t: &mut [f32], mut uniform: impl FnMut() -> f32) {
    let mut lower = t.first().copied().unwrap_or(0.0);
    for i in 0..t.len() {
        let upper = t.get(i + 1).map_or(t[i], |next| 0.5 * (t[i] + next));
        t[i] = lower + (upper - lower) * uniform();
        lower = upper;
    }
}

/// Where the last sample's part of a ray ends if nothing else ends it.
pub const ENDLESS: f32 = 1e10;

/// The lengths that samples at the distances `t` stand for: each what lies between it and
/// the next, the last what lies before `end`: where a ray leaves the space, or
/// [`ENDLESS`]. Those beyond `t.len()` become 0.
pub fn lengths(t: &[f32], end: f32, lengths: &mut [f32]) {
    let (own, rest) = lengths.split_at_mut(t.len());
    rest.fill(0.0);
    let next = t.iter().skip(1).chain([&end]);
    for ((length, t), next) in own.iter_mut().zip(t).zip(next) {
        *length = next - t;
    }
}

/// Opacities to weights, in place: what of the light that passes a sample is held back
/// there.
pub fn weights(alpha: &mut [f32]) {
    let mut transmittance = 1.0;
    for alpha in alpha {
        let passed = 1.0 - *alpha;
        *alpha *= transmittance;
        transmittance *= passed;
    }
}

/// Distances where the `weights` of samples at `t` are: the inverse of their cumulative
/// distribution, taken as even between the middles of neighbours. `at` returns what is to
/// be inverted for each of `found`, ascending from 0 to 1; so are the distances.
pub fn inverse_cdf(t: &[f32], weights: &[f32], at: impl Fn(usize) -> f32, found: &mut [f32]) {
    let n = t.len().min(weights.len());
    if n < 3 {
        return;
    }
    let middle = |i: usize| 0.5 * (t[i] + t[i + 1]);
    // The first and the last sample's weight do not count; a little everywhere lets no
    // bin be forgotten. What is no number counts as nothing.
    let weight = |i: usize| weights[i + 1].max(0.0) + 1e-5;
    let total: f32 = (0..n - 2).map(weight).sum();
    let (mut bin, mut before) = (0, 0.0);
    for (i, found) in found.iter_mut().enumerate() {
        let at = at(i);
        let mut part = weight(bin) / total;
        while bin + 3 < n && before + part <= at {
            before += part;
            bin += 1;
            part = weight(bin) / total;
        }
        let inside = ((at - before) / if part < 1e-5 { 1.0 } else { part }).clamp(0.0, 1.0);
        *found = middle(bin) + inside * (middle(bin + 1) - middle(bin));
    }
}

/// Two ascending lists as one.
pub fn merge(first: &[f32], second: &[f32], all: &mut [f32]) {
    let (mut a, mut b) = (first.iter().peekable(), second.iter().peekable());
    for to in all {
        let take_second = match (a.peek(), b.peek()) {
            (Some(a), Some(b)) => b < a,
            (a, _) => a.is_none(),
        };
        *to = if take_second { b.next() } else { a.next() }.copied().unwrap_or(f32::INFINITY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::composite::{Lengths, opacities};

    #[test]
    fn even_and_jittered_by_hand() {
        let mut t = [0.0; 5];
        evenly(2.0, 6.0, &mut t);
        assert_eq!(t, [2.0, 3.0, 4.0, 5.0, 6.0]);
        let mut moved = t;
        jitter(&mut moved, || 0.0);
        assert_eq!(moved, [2.0, 2.5, 3.5, 4.5, 5.5]);
        jitter(&mut t, || 0.5);
        assert_eq!(t, [2.25, 3.0, 4.0, 5.0, 5.75]);
    }

    #[test]
    fn weights_by_hand() {
        // sigma δ is ln 2 for the first two samples: half of the light each.
        let ln_2 = core::f32::consts::LN_2;
        let mut values = [ln_2, 0.5 * ln_2, 0.0, 1.0, 9.0];
        let level = crate::SimdLevel::compiled().token().unwrap();
        let mut padded = [0.0; 16];
        padded[..4].copy_from_slice(&values[..4]);
        let mut own = [1.0; 16];
        lengths(&[1.0, 2.0, 4.0, 5.0], ENDLESS, &mut own);
        assert_eq!(own[..5], [1.0, 2.0, 1.0, ENDLESS - 5.0, 0.0]);
        fearless_simd::dispatch!(level, simd => {
            opacities(simd, &mut padded, Lengths::Each(&own, 1.0));
        });
        weights(&mut padded[..4]);
        values.copy_from_slice(&padded[..5]);
        for (found, expected) in values.iter().zip([0.5, 0.25, 0.0, 0.25, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{values:?}");
        }
    }

    #[test]
    fn samples_where_the_weights_are() {
        // Middles 0.5, 1.5, 2.5, 3.5: three bins, weights 0, 3 and 1 (the ends' do not
        // count). A quarter into the distribution is a third of the second bin.
        let (t, weights) = ([0.0, 1.0, 2.0, 3.0, 4.0], [7.0, 0.0, 3.0, 1.0, 7.0]);
        let mut found = [0.0; 5];
        inverse_cdf(&t, &weights, |i| i as f32 / 4.0, &mut found);
        let expected = [0.5, 1.5 + 1.0 / 3.0, 1.5 + 2.0 / 3.0, 2.5, 3.5];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 2e-4, "{found} {expected}");
        }
        // Nothing anywhere: evenly.
        inverse_cdf(&t, &[f32::NAN; 5], |i| i as f32 / 4.0, &mut found);
        for (i, found) in found.iter().enumerate() {
            assert!((found - (0.5 + 0.75 * i as f32)).abs() < 1e-3, "{found}");
        }
    }

    #[test]
    fn two_lists_become_one() {
        let mut all = [0.0; 7];
        merge(&[1.0, 4.0, 5.0], &[0.5, 4.0, 4.5, 9.0], &mut all);
        assert_eq!(all, [0.5, 1.0, 4.0, 4.0, 4.5, 5.0, 9.0]);
    }
}
