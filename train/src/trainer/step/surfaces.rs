//! Smooth surfaces, where they are asked for.
//!
//! Where nothing but its outline tells how deep a surface lies, as on walls and bodies of one
//! colour, a field is free to be rough. So some rays are drawn in rows of three neighbours, and
//! a middle one that is deeper, or less deep, than a flat surface through the other two is an
//! error (as of depths in patches: Niemeyer et al., "RegNeRF", 2022, equation 4). Edges are
//! meant to be there: the sharper a bend, the less it counts.

use glam::DVec3;
use pocketnerf_core::{Ray, Space};

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
const EDGE: f64 = 0.5;

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
    pub(super) fn hold_smooth(&mut self, weight: f32, space: &Space) {
        for &first in &self.rows {
            let row = [1, 0, 2].map(|i| first as usize + i);
            if row.iter().any(|&r| self.accumulated[r].opacity < OPAQUE) {
                continue;
            }
            let depths = row.map(|r| self.accumulated[r].expected_depth());
            let local = |i: usize| Some(space.piece(&self.rays[row[i]].ray, depths[i])?.local);
            let (Some(before), Some(middle), Some(after)) = (local(0), local(1), local(2)) else {
                continue;
            };
            let Some((_, gradient)) = bend([before, middle, after], depths) else { continue };
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

/// How much the surface points of three rays in a row bend, and the gradient by their distances.
/// All is in local coordinates, in which rays and planes are straight. `None` where that is not
/// known.
fn bend(rays: [Ray; 3], depths: [f32; 3]) -> Option<(f32, [f32; 3])> {
    // What is met at the camera itself is no surface.
    if depths.iter().any(|depth| depth.is_nan() || *depth <= 0.0) {
        return None;
    }
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let depths = depths.map(f64::from);
    let [o0, o1, o2] = rays.map(|ray| vector(ray.origin));
    let [d0, d1, d2] = rays.map(|ray| vector(ray.direction));
    let (before, after) = (o0 + depths[0] * d0, o2 + depths[2] * d2);
    let across = after - before;
    // How far a way leads off the line between the other two points, in the plane of that line and
    // the middle ray, where the middle ray's own leads 1 off it.
    let normal = d1.cross(across);
    let off_line = |way: DVec3| way.cross(across).dot(normal) / normal.length_squared();
    let flat = off_line(before - o1);
    // Where along the line the middle ray meets it.
    let share = (o1 + flat * d1 - before).dot(across) / across.length_squared();
    let apart = 0.5 * across.length();
    let (off, edge) = ((depths[1] - flat) / apart, EDGE * EDGE);
    // off^2 / 2 where that is small (Geman and McClure).
    let kept = edge / (edge + off * off);
    let d = off * kept * kept / apart;
    let gradient = [-d * (1.0 - share) * off_line(d0), d, -d * share * off_line(d2)];
    let (found, gradient) = ((0.5 * off * off * kept) as f32, gradient.map(|d| d as f32));
    gradient.iter().all(|d| d.is_finite()).then_some((found, gradient))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use pocketnerf_core::march::composite::Accumulated;
    use pocketnerf_core::space::{Contracted, Ndc};

    use super::*;
    use crate::dataset::View;
    use crate::trainer::pixels::neighbours::tests::at;
    use crate::trainer::pixels::rays::{Backdrop, RaySource, TrainingRay};
    use crate::trainer::step::group::RayGradient;

    /// A box that holds all there is in these tests.
    const ALL: Space = Space::Box { min: [-9.0; 3], max: [9.0; 3] };

    /// Rays to points of the plane z = 2 that are 0.2 apart, and their distances.
    fn flat() -> ([Ray; 3], [f32; 3]) {
        let points = [0.3, 0.5, 0.7].map(|x| Vec3::new(x, 0.1, 2.0));
        (points.map(towards), points.map(Vec3::length))
    }

    fn towards(point: Vec3) -> Ray {
        Ray { origin: [0.0; 3], direction: point.normalize().to_array() }
    }

    #[test]
    fn a_plane_does_not_bend() {
        let (rays, depths) = flat();
        let (bend, gradient) = bend(rays, depths).unwrap();
        assert!(bend < 1e-8, "{bend}");
        assert!(gradient.iter().all(|d| d.abs() < 1e-2), "{gradient:?}");
    }

    #[test]
    fn a_plane_bends_in_no_space() {
        let ndc = Ndc { near: 0.5, slope: [1.0, 2.0], min: [-1.0; 3], max: [1.0; 3] };
        let around = Contracted { center: [0.2, 0.1, 0.3], radius: 0.7 };
        let (twice, eye) = (2.0 * ndc.near, Vec3::new(0.1, -0.2, 0.3));
        // On the plane z = -3 + x / 2, well beyond the cube.
        let points = [0.3, 0.5, 0.7].map(|x: f32| Vec3::new(x, 0.1, 0.5 * x - 3.0));
        let in_ndc = |p: Vec3| Vec3::new(-p.x / p.z, -2.0 * p.y / p.z, 1.0 + twice / p.z);
        let contracted = |p: Vec3| Vec3::from(around.local_point(p.to_array()));
        let local: [(Space, &dyn Fn(Vec3) -> Vec3); 2] =
            [(Space::Ndc(ndc), &in_ndc), (Space::Contracted(around), &contracted)];
        for (space, place) in local {
            let way = |point: Vec3| Ray {
                origin: eye.to_array(),
                direction: (point - eye).normalize().to_array(),
            };
            let last = |ray: Ray| space.piece(&ray, 0.99 * space.whole_way(&ray).unwrap());
            let pieces = points.map(|point| last(way(point)).unwrap().local);
            let depths = [0, 1, 2].map(|i| {
                let from = place(points[i]) - Vec3::from(pieces[i].origin);
                let t = from.dot(pieces[i].direction.into());
                assert!((from.length() - t).abs() < 1e-4, "{space:?}: on its ray");
                t
            });
            let (found, _) = bend(pieces, depths).unwrap();
            assert!(found < 1e-7, "{space:?}: {found}");
            // Off it by a tenth of what lies between the others.
            let apart = 0.5 * (place(points[2]) - place(points[0])).length();
            let off = [depths[0], depths[1] + 0.1 * apart, depths[2]];
            let (found, _) = bend(pieces, off).unwrap();
            assert!((found / (0.005 * 0.25 / 0.26) - 1.0).abs() < 1e-2, "{space:?}: {found}");
        }
    }

    #[test]
    fn the_loss_by_hand_and_edges_count_less() {
        let (rays, [t0, t1, t2]) = flat();
        for (off, expected) in [(0.02, 0.01 / 2.0 * 0.25 / 0.26), (2.0, 50.0 * 0.25 / 100.25)] {
            // The neighbours are 0.4 apart, hence 0.2 from the middle.
            let (found, _) = bend(rays, [t0, t1 + off, t2]).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-2, "{off}: {found}, by hand {expected}");
        }
        let slope = |off: f32| bend(rays, [t0, t1 + off, t2]).unwrap().1[1];
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
        let edge = EDGE * EDGE;
        0.5 * off * off * edge / (edge + off * off)
    }

    #[test]
    fn gradients_by_what_rays_accumulate_are_differences() {
        let points = [[-0.2, 2.0], [0.1, 2.1], [0.4, 2.2]].map(|[x, z]| Vec3::new(x, 0.1, z));
        let source = RaySource::new(vec![View::new("", at(0.0), vec![255; 4])], Backdrop::Random);
        let mut random = Random::new(1, [0; 3]);
        let ray = |point: Vec3, random: &mut Random| TrainingRay {
            ray: towards(point),
            weight: 3.0,
            ..source.draw_anywhere(false, random)
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
        group.hold_smooth(0.5, &ALL);
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
        group.hold_smooth(0.5, &ALL);
        assert!(group.ray_gradients.iter().all(|d| d.depth == 0.0 && d.opacity == 0.0));
    }

    #[test]
    fn what_has_no_surface_has_no_gradient() {
        let (rays, [t0, t1, t2]) = flat();
        assert_eq!(bend([rays[0]; 3], [t0; 3]), None);
        assert_eq!(bend(rays, [t0, f32::NAN, t2]), None);
        assert_eq!(bend(rays, [0.0, t1, t2]).map(|(bend, _)| bend.is_finite()), None);
        assert_eq!(bend(rays, [t0, t1, f32::INFINITY]), None);
        assert_eq!(bend(rays, [t0, f32::INFINITY, t2]), None);
    }
}
