//! The Pareto frontier: the points that no other point dominates.

use super::{Axis, Better, Point};

/// For each point whether it lies on the frontier of these axes: no other point of its
/// [group](Point::group) and program is at least as good on both and better on one.
/// Programs have frontiers of their own, because their machines may differ. A point without
/// a figure on an axis is ignored.
#[must_use]
pub fn frontier(points: &[Point], x: Axis, y: Axis) -> Vec<bool> {
    let place = |point: &Point| Some([cost(x, point)?, cost(y, point)?]);
    let places: Vec<_> = points.iter().map(place).collect();
    let all = || points.iter().zip(&places);
    all()
        .map(|(point, place)| {
            let Some(place) = place else { return false };
            let beats = |other: &[f64; 2]| {
                other != place && other.iter().zip(place).all(|(other, own)| other <= own)
            };
            let competes =
                |other: &Point| other.group() == point.group() && other.program == point.program;
            !all().any(|(other, place)| competes(other) && place.as_ref().is_some_and(beats))
        })
        .collect()
}

/// A figure of which less is better.
fn cost(axis: Axis, point: &Point) -> Option<f64> {
    let value = axis.value(point)?;
    Some(match axis.better() {
        Better::Less => value,
        Better::More => -value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(places: &[(f64, f64)]) -> Vec<Point> {
        let point = |&(ms, psnr): &(f64, f64)| Point {
            ms_per_frame: Some(ms),
            psnr: Some(psnr),
            ..Point::default()
        };
        places.iter().map(point).collect()
    }

    #[test]
    fn dominated_points_are_found() {
        let mut all = points(&[(1.0, 20.0), (2.0, 30.0), (3.0, 29.0), (4.0, 30.0), (2.0, 30.0)]);
        let on = |points: &[Point]| frontier(points, Axis::MsPerFrame, Axis::Psnr);
        // Slower and worse, or as good but slower: dominated. Of equal points both stay.
        assert_eq!(on(&all), [true, true, false, false, true]);
        // Another scene has its own frontier.
        all[3].scene = "another".to_owned();
        assert_eq!(on(&all), [true, true, false, true, true]);
        all[1].psnr = None;
        assert_eq!(on(&all), [true, false, false, true, true]);
    }
}
