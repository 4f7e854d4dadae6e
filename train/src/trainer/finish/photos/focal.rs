//! A focal length that is wrong: a field bends until photographs agree, but near parts of a scene
//! remain too large or too small beside far ones.

use super::compare::{DIFFERENCE, LAPLACIAN, Products, RADIAL, RADIAL_BY_DEPTH};

/// Near parts may be so much larger or smaller: a focal length that is wrong by a tenth shows as
/// 0.009, the field makes up for the rest ...
const LARGER: f64 = 5e-3;
/// ... and nothing that is a focal length's shows as more.
const MOST: f64 = 0.06;
/// It is known where it is so many times its standard error.
const SURE: f64 = 6.0;
/// Views that say something, at least.
const FEWEST: usize = 8;

/// By which share photographs are magnified more than the model's pictures where a scene's depth
/// is half as large: above 0 where the focal length is too long. 0 where that is not known.
pub(super) fn magnification(views: &[Vec<Products>]) -> f64 {
    let (mut of_views, mut inverse_depth) = (Vec::new(), [0.0; 2]);
    for parts in views {
        let mut view = Products::default();
        for part in parts {
            inverse_depth[0] += part.of(RADIAL, RADIAL_BY_DEPTH);
            inverse_depth[1] += part.of(RADIAL, RADIAL);
            view.add(part);
        }
        // A shift, blur and magnification are each view's own.
        let left = view.in_place().without(LAPLACIAN).without(RADIAL);
        let weight = left.of(RADIAL_BY_DEPTH, RADIAL_BY_DEPTH);
        if weight > 0.0 {
            of_views.push([-left.of(RADIAL_BY_DEPTH, DIFFERENCE), weight]);
        }
    }
    let n = of_views.len() as f64;
    if of_views.len() < FEWEST {
        return 0.0;
    }
    let weights: f64 = of_views.iter().map(|[_, weight]| weight).sum();
    let slope = of_views.iter().map(|[product, _]| product).sum::<f64>() / weights;
    let off = of_views.iter().map(|[product, weight]| (product - slope * weight).powi(2));
    let error = (off.sum::<f64>() * n / (n - 1.0)).sqrt() / weights;
    let found = slope * inverse_depth[0] / inverse_depth[1];
    let is_known = slope.abs() > SURE * error && (LARGER..MOST).contains(&found.abs());
    if is_known { found } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::compare::tests::{compare, picture};
    use super::*;

    /// Views whose left half is nearer and, in photographs, magnified by `by`, which is not known
    /// exactly.
    fn views(by: f64) -> Vec<Vec<Products>> {
        let model = picture(|at| at, 1.0);
        let depth: Vec<f32> = (0..1600).map(|i| if i % 40 < 20 { 2.0 } else { 4.0 }).collect();
        let view = |i: usize| {
            let scale = |at: DVec2| {
                let off = if i.is_multiple_of(2) { 0.001 } else { -0.001 };
                1.0 + if at.x < 20.0 { by + off } else { 0.0 }
            };
            let center = DVec2::splat(20.0);
            let photo = picture(|at| center + (at - center) / scale(at), 1.0);
            vec![compare(&model, &photo, &depth).unwrap()]
        };
        (0..12).map(view).collect()
    }

    #[test]
    fn what_is_near_is_larger_or_smaller() {
        let [none, long, short, few] = [0.0, 0.02, -0.02, 0.02].map(views);
        assert_eq!(magnification(&none), 0.0);
        let [long, short] = [magnification(&long), magnification(&short)];
        // A depth of 4 beside one of 2: inverse depths differ by two thirds of their mean, about.
        assert!((0.02..0.04).contains(&long) && (-0.04..-0.02).contains(&short), "{long} {short}");
        assert_eq!(magnification(&few[..7]), 0.0);
    }
}
