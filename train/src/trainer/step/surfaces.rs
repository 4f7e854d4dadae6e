//! Smooth surfaces, where they are asked for.
//!
//! Where nothing but its outline tells how deep a surface lies, as on walls and bodies of one
//! colour, a field is free to be rough. So some rays are drawn in rows of three neighbours, and
//! a middle one that is deeper, or less deep, than a flat surface through the other two is an
//! error (as of depths in patches: Niemeyer et al., "RegNeRF", 2022, equation 4). Edges are
//! meant to be there: the sharper a bend, the less it counts.

use glam::Vec3;

use super::group::Group;
use crate::random::Random;
use crate::trainer::backend::StepInput;
use crate::trainer::pixels::rays::Pixel;

/// One row of three in so many rays.
const EVERY: usize = 12;
/// Rays of a row are 1, 2, 4, ... pixels apart: so many distances.
const DISTANCES: usize = 4;
/// Rays of less opacity meet no surface.
const OPAQUE: f32 = 0.9;
/// A bend counts half as much as a small one where the middle is off by so much of the distance to
/// its neighbours.
const EDGE: f32 = 0.5;

impl Group {
    /// Moves some of the pixels that are drawn to both sides of another one.
    pub(super) fn draw_rows(&mut self, input: &StepInput<'_>, random: &mut Random) {
        self.rows.clear();
        if input.smooth_surfaces <= 0.0 {
            return;
        }
        for first in (0..self.pixels.len().saturating_sub(2)).step_by(EVERY) {
            let apart = 1 << random.below(DISTANCES);
            let by = if random.below(2) == 0 { [apart, 0] } else { [0, apart] };
            let Some(sides) = sides(input, self.pixels[first], by) else { continue };
            self.pixels[first + 1..][..2].copy_from_slice(&sides);
            let drawn = self.drawn[first];
            self.drawn[first + 1..][..2].fill(drawn);
            self.rows.push(first as u32);
        }
    }

    /// Adds the gradient of what is bent, times `weight`.
    pub(super) fn hold_smooth(&mut self, weight: f32) {
        for &first in &self.rows {
            let row = [1, 0, 2].map(|i| first as usize + i);
            if row.iter().any(|&r| self.accumulated[r].opacity < OPAQUE) {
                continue;
            }
            let directions = row.map(|r| Vec3::from(self.rays[r].ray.direction));
            let depths = row.map(|r| self.accumulated[r].expected_depth());
            let Some((_, gradient)) = bend(directions, depths) else { continue };
            for (r, d) in row.into_iter().zip(gradient) {
                let accumulated = &self.accumulated[r];
                // depth = sum / opacity.
                let d_sum = weight * self.rays[r].weight * d / accumulated.opacity;
                self.ray_gradients[r].depth += d_sum;
                self.ray_gradients[r].opacity -= d_sum * accumulated.expected_depth();
            }
        }
    }
}

/// The pixels on both sides of a pixel, where both may be drawn.
fn sides(input: &StepInput<'_>, middle: Pixel, by: [i32; 2]) -> Option<[Pixel; 2]> {
    let camera = &input.source.cameras()[middle.view as usize];
    let side = |sign: i32| {
        let x = middle.x.checked_add_signed(sign * by[0])?;
        let y = middle.y.checked_add_signed(sign * by[1])?;
        let pixel = Pixel { x, y, ..middle };
        let is_inside = x < camera.width && y < camera.height;
        (is_inside && input.visibility.draws(pixel)).then_some(pixel)
    };
    Some([side(-1)?, side(1)?])
}

/// How much three surface points in a row bend, and the gradient by their distances along rays
/// from one point. `None` where that is not known.
fn bend(directions: [Vec3; 3], depths: [f32; 3]) -> Option<(f32, [f32; 3])> {
    let ([before, middle, after], [t0, t1, t2]) = (directions, depths);
    // middle = a before + b after: its ray meets the line between the other two points where
    // a t / t0 + b t / t2 = 1.
    // By products of differences: those of unit vectors that are nearly parallel would be lost.
    let normal = before.cross(after - before);
    let part =
        |one: Vec3, other: Vec3| one.cross(other - one).dot(normal) / normal.length_squared();
    let (a, b) = (part(middle, after), part(before, middle));
    let flat = 1.0 / (a / t0 + b / t2);
    let apart = 0.5 * (t0 * before - t2 * after).length();
    let (off, edge) = ((t1 - flat) / apart, EDGE * EDGE);
    // off^2 / 2 where that is small (Geman and McClure).
    let share = edge / (edge + off * off);
    let d = off * share * share / apart;
    let [d0, d2] = [(a, t0), (b, t2)].map(|(part, t)| -d * part * (flat / t) * (flat / t));
    let found = (0.5 * off * off * share, [d0, d, d2]);
    [d0, d, d2].iter().all(|d| d.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use pocketnerf_core::Ray;
    use pocketnerf_core::march::composite::Accumulated;

    use super::*;
    use crate::dataset::View;
    use crate::trainer::pixels::neighbours::tests::at;
    use crate::trainer::pixels::rays::{Backdrop, RaySource, TrainingRay};
    use crate::trainer::step::group::RayGradient;

    /// Directions to points of the plane z = 2 that are 0.2 apart, and their distances.
    fn flat() -> ([Vec3; 3], [f32; 3]) {
        let points = [0.3, 0.5, 0.7].map(|x| Vec3::new(x, 0.1, 2.0));
        (points.map(Vec3::normalize), points.map(Vec3::length))
    }

    #[test]
    fn a_plane_does_not_bend() {
        let (directions, depths) = flat();
        let (bend, gradient) = bend(directions, depths).unwrap();
        assert!(bend < 1e-8, "{bend}");
        assert!(gradient.iter().all(|d| d.abs() < 1e-2), "{gradient:?}");
    }

    #[test]
    fn the_loss_by_hand_and_edges_count_less() {
        let (directions, [t0, t1, t2]) = flat();
        for (off, expected) in [(0.02, 0.01 / 2.0 * 0.25 / 0.26), (2.0, 50.0 * 0.25 / 100.25)] {
            // The neighbours are 0.4 apart, hence 0.2 from the middle.
            let (found, _) = bend(directions, [t0, t1 + off, t2]).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-2, "{off}: {found}, by hand {expected}");
        }
        let slope = |off: f32| bend(directions, [t0, t1 + off, t2]).unwrap().1[1];
        assert!(slope(2.0) < 0.05 * slope(0.05), "{} {}", slope(2.0), slope(0.05));
    }

    /// The loss in f64, from the sums of three rays: where the middle ray meets the line through
    /// the other two points, by Cramer's rule. The distance between these is a scale, which the
    /// gradient does not follow.
    fn loss(directions: [DVec3; 3], sums: [[f64; 2]; 3], apart: f64) -> f64 {
        let [t0, t1, t2] = sums.map(|[depth, opacity]| depth / opacity);
        let [before, middle, after] = directions;
        let (from, along) = (t0 * before, t2 * after - t0 * before);
        // from + s along = t middle, in the plane of the first two axes.
        let t = (from.x * along.z - from.z * along.x) / (middle.x * along.z - middle.z * along.x);
        let off = (t1 - t) / apart;
        let edge = f64::from(EDGE * EDGE);
        0.5 * off * off * edge / (edge + off * off)
    }

    #[test]
    fn gradients_by_what_rays_accumulate_are_differences() {
        let points = [[-0.2, 2.0], [0.1, 2.1], [0.4, 2.2]].map(|[x, z]| Vec3::new(x, 0.1, z));
        let source = RaySource::new(vec![View::new("", at(0.0), vec![255; 4])], Backdrop::Random);
        let mut random = Random::new(1, [0; 3]);
        let ray = |point: Vec3, random: &mut Random| {
            let direction = point.normalize().to_array();
            let ray = Ray { origin: [0.0; 3], direction };
            TrainingRay { ray, weight: 3.0, ..source.draw_anywhere(false, random) }
        };
        // The middle one is first, and too deep; none is quite opaque.
        let order = [1, 0, 2];
        let accumulated = order.map(|i| {
            let opacity = [0.92, 0.95, 0.97][i];
            let t = points[i].length() + [0.0, 0.05, 0.0][i];
            Accumulated { opacity, transmittance: 1.0 - opacity, depth: opacity * t }
        });
        let mut group = Group {
            rays: order.map(|i| ray(points[i], &mut random)).into(),
            accumulated: accumulated.into(),
            ray_gradients: vec![RayGradient::default(); 3],
            rows: vec![0],
            ..Group::default()
        };
        group.hold_smooth(0.5);
        let sums = order.map(|r| accumulated[r]).map(|a| [a.depth, a.opacity].map(f64::from));
        let directions = points.map(|p| p.as_dvec3().normalize());
        let depth = |i: usize| sums[i][0] / sums[i][1];
        let apart = 0.5 * (depth(0) * directions[0] - depth(2) * directions[2]).length();
        for (i, r) in order.into_iter().enumerate() {
            let found = [group.ray_gradients[r].depth, group.ray_gradients[r].opacity];
            for (which, found) in found.into_iter().enumerate() {
                let at = |by: f64| {
                    let mut sums = sums;
                    sums[i][which] += by;
                    loss(directions, sums, apart)
                };
                let expected = 3.0 * 0.5 * (at(1e-6) - at(-1e-6)) / 2e-6;
                let off = (f64::from(found) / expected - 1.0).abs();
                assert!(off < 1e-3, "{i}, {which}: {found}, not {expected}");
            }
        }
        // What lets light pass has no surface.
        group.accumulated[2].opacity = 0.8;
        group.ray_gradients.fill(RayGradient::default());
        group.hold_smooth(0.5);
        assert!(group.ray_gradients.iter().all(|d| d.depth == 0.0 && d.opacity == 0.0));
    }

    #[test]
    fn what_has_no_surface_has_no_gradient() {
        let (directions, [t0, t1, t2]) = flat();
        assert_eq!(bend([directions[0]; 3], [t0; 3]), None);
        assert_eq!(bend(directions, [t0, f32::NAN, t2]), None);
        assert_eq!(bend(directions, [0.0, t1, t2]).map(|(bend, _)| bend.is_finite()), None);
    }
}
