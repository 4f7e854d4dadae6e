//! Rays through the cube: opacities are added up until they are 1.

use glam::Vec3;
use pocketnerf_core::Ray;

use super::grid::{Between, Grid};
use crate::network::Real;
use crate::photographs::Place;

/// A step, in half sides of the cube.
const STEP: f32 = 1.0 / 32.0;
/// Steps of the longest way through the cube, and one.
const MOST_STEPS: f32 = 112.0;

/// The template, four channels: sRGB and opacity a half side; and where each place of the cube is
/// in it, three channels.
#[derive(Debug)]
pub(super) struct Volume<T> {
    pub(super) template: Grid<T>,
    pub(super) warp: Grid<T>,
}

/// One sample.
struct Sample<T> {
    place: Between<T>,
    template: Between<T>,
    color: [T; 3],
    /// What it adds to the opacity.
    weight: T,
}

/// What a ray has met.
pub(super) struct Pass<T> {
    samples: Vec<Sample<T>>,
    /// Whether the last sample took all that was left.
    is_full: bool,
    /// Premultiplied colour and opacity.
    pub(super) rgba: [T; 4],
}

impl<T: Real> Volume<T> {
    /// The way of a ray; `offset` is where samples lie in their steps, 0 to 1.
    pub(super) fn march(&self, place: &Place, ray: &Ray, offset: f32) -> Pass<T> {
        let mut pass = Pass { samples: Vec::new(), is_full: false, rgba: [T::zero(); 4] };
        let [origin, direction] = place.ray(ray);
        let Some([near, far]) = crossing(origin, direction) else { return pass };
        // Far from the cube, a step may be too short to go anywhere.
        let steps = ((far - near) / STEP).min(MOST_STEPS);
        let mut step = offset;
        while step < steps && !pass.is_full {
            let at = origin + direction * (near + STEP * step);
            let at = [at.x, at.y, at.z].map(|p| T::of(f64::from(p)));
            step += 1.0;
            // Rounding may put the ends of a ray outside.
            let Some(between) = self.warp.find(at) else { continue };
            let warped = self.warp.values_at::<3>(&between, 0);
            let Some(template) = self.template.find(warped) else { continue };
            let [r, g, b, opacity] = self.template.values_at::<4>(&template, 0);
            let left = T::one() - pass.rgba[3];
            let adds = opacity * T::of(f64::from(STEP));
            pass.is_full = adds >= left;
            let weight = if pass.is_full { left } else { adds };
            let color = [r, g, b];
            for (sum, value) in pass.rgba.iter_mut().zip([r, g, b, T::one()]) {
                *sum += weight * value;
            }
            pass.samples.push(Sample { place: between, template, color, weight });
        }
        pass
    }

    /// From the gradient of colour and opacity to those of template and warp, which are added.
    pub(super) fn backward(&self, pass: &Pass<T>, d: [T; 4], sums: &mut Self) {
        let gain = |sample: &Sample<T>| d[3] + (0..3).map(|c| d[c] * sample.color[c]).sum::<T>();
        // The last sample took what the others left.
        let last = pass.samples.last().filter(|_| pass.is_full).map_or(T::zero(), gain);
        for (i, sample) in pass.samples.iter().enumerate() {
            let rest = pass.is_full && i + 1 == pass.samples.len();
            let opacity = match rest {
                true => T::zero(),
                false => (gain(sample) - last) * T::of(f64::from(STEP)),
            };
            let [r, g, b] = [0, 1, 2].map(|c| d[c] * sample.weight);
            let d = [r, g, b, opacity];
            sums.template.add(&sample.template, 0, d);
            sums.warp.add(&sample.place, 0, self.template.slope(&sample.template, 0, d));
        }
    }

    /// The same sizes, zero.
    pub(super) fn empty(&self) -> Self {
        Self { template: self.template.empty(), warp: self.warp.empty() }
    }
}

/// Where a ray enters the cube and leaves it.
fn crossing(origin: Vec3, direction: Vec3) -> Option<[f32; 2]> {
    let inverse = direction.recip();
    let (a, b) = ((Vec3::NEG_ONE - origin) * inverse, (Vec3::ONE - origin) * inverse);
    let near = a.min(b).max_element().max(0.0);
    let far = a.max(b).min_element();
    (near < far).then_some([near, far])
}
