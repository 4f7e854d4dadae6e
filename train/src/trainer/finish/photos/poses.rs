//! Cameras that are not quite where they should be: each photograph is shifted as a whole.

use glam::DVec2;

use super::compare::Products;
use crate::metrics::{mean, median};

/// Photographs are shifted as a whole where that is so much of the shifts of their parts, of half
/// of them: what a field has not learnt shifts each part elsewhere ...
const TOGETHER: f64 = 0.2;
/// ... and by so many pixels.
const PIXELS: f64 = 0.02;
/// Parts of a view that say something, at least.
const FEWEST: usize = 3;

/// By how many pixels photographs are shifted as a whole, root mean square; 0 where they are not.
pub(super) fn shift(views: &[Vec<Products>]) -> f64 {
    let views: Vec<[f64; 2]> = views.iter().filter_map(|parts| together(parts)).collect();
    let share = median(views.iter().map(|[whole, all]| whole / all)).unwrap_or(0.0);
    // The square of the shift of a whole may be estimated below 0.
    let squared = mean(views.iter().map(|[whole, _]| *whole)).unwrap_or(0.0);
    let shift = squared.max(0.0).sqrt();
    if share > TOGETHER && shift > PIXELS { shift } else { 0.0 }
}

/// Squared shifts: what the parts of a view have in common, and all of it, weighted by how well
/// each is known.
///
/// Of parts whose errors are independent, the products of two different ones have the square of
/// what they have in common as their mean.
fn together(parts: &[Products]) -> Option<[f64; 2]> {
    if parts.len() < FEWEST {
        return None;
    }
    let all: f64 = parts.iter().map(Products::texture).sum();
    let (mut sum, mut own, mut squares, mut weights) = (DVec2::ZERO, 0.0, 0.0, 0.0);
    for part in parts {
        let (weight, shift) = (part.texture() / all, part.shift());
        sum += weight * shift;
        own += weight * weight * shift.length_squared();
        squares += weight * shift.length_squared();
        weights += weight * weight;
    }
    Some([(sum.length_squared() - own) / (1.0 - weights), squares])
}

#[cfg(test)]
mod tests {
    use super::super::compare::tests::{compare, picture};
    use super::*;

    /// Views of which each part is shifted by what `by` says of view and part.
    fn views(by: impl Fn(usize, usize) -> DVec2) -> Vec<Vec<Products>> {
        let model = picture(|at| at, 1.0);
        let part = |view, part| {
            let photo = picture(|at| at - by(view, part), 1.0);
            compare(&model, &photo, &[4.0; 1600]).unwrap()
        };
        (0..6).map(|view| (0..8).map(|i| part(view, i)).collect()).collect()
    }

    #[test]
    fn only_what_parts_have_in_common_counts() {
        let turned = |length: f64, i: usize| length * DVec2::from_angle(2.4 * i as f64);
        let whole = shift(&views(|view, part| turned(0.2, view) + turned(0.1, 3 * view + part)));
        assert!((whole - 0.2).abs() < 0.02, "{whole}");
        assert_eq!(shift(&views(|view, part| turned(0.3, 3 * view + part))), 0.0);
        assert_eq!(shift(&views(|view, _| turned(0.01, view))), 0.0);
        assert_eq!(shift(&[]), 0.0);
    }
}
