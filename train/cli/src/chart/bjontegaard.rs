//! Compares two methods by one number: Bjøntegaard's differences (VCEG-M33, 2001), with the
//! piecewise cubic interpolation of JCTVC-B055 that does not overshoot.
//!
//! Here the rate is the cost of a picture: milliseconds or bytes.

use super::{Axis, Better, Point, frontier};

/// The fewest points of a curve.
pub const LEAST: usize = 4;

/// How two methods differ on average over the range that their curves share.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Scene and picture size.
    pub group: String,
    /// The method that is compared with.
    pub anchor: String,
    /// The method that is compared.
    pub method: String,
    /// The cost: an axis' key.
    pub cost: &'static str,
    /// How much more the method costs at equal PSNR, per cent; `None`: too few points on
    /// the frontier, or no common range.
    pub bd_rate: Option<f64>,
    /// By how much its PSNR is higher at equal cost, dB.
    pub bd_psnr: Option<f64>,
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { group, anchor, method, cost, .. } = self;
        write!(f, "{group}: {method} against {anchor}, by {cost}: ")?;
        let signed = |value: Option<f64>, unit: &str| match value {
            Some(value) => format!("{value:+.2} {unit}"),
            None => "none in common".to_owned(),
        };
        let (rate, psnr) = (signed(self.bd_rate, "%"), signed(self.bd_psnr, "dB"));
        write!(f, "BD-rate {rate}, BD-PSNR {psnr}")
    }
}

/// Compares every two series of each group of points.
#[must_use]
pub fn compare(points: &[Point], cost: Axis) -> Vec<Comparison> {
    let mut found = Vec::new();
    for group in super::groups(points) {
        let of_group = points.iter().filter(|point| point.group() == group);
        let mut series: Vec<&str> = Vec::new();
        of_group.for_each(|p| {
            if !series.contains(&p.series()) {
                series.push(p.series());
            }
        });
        let curves: Vec<_> = series
            .iter()
            .map(|series| {
                let own = |p: &&Point| p.group() == group && p.series() == *series;
                curve(&points.iter().filter(own).cloned().collect::<Vec<_>>(), cost)
            })
            .collect();
        for (i, anchor) in curves.iter().enumerate() {
            for (j, method) in curves.iter().enumerate().skip(i + 1) {
                found.push(Comparison {
                    group: group.to_string(),
                    anchor: series[i].to_owned(),
                    method: series[j].to_owned(),
                    cost: cost.key(),
                    bd_rate: bd_rate(anchor, method),
                    bd_psnr: bd_psnr(anchor, method),
                });
            }
        }
    }
    found
}

/// Cost and PSNR of the points on the method's own frontier, both rising.
fn curve(points: &[Point], cost: Axis) -> Vec<[f64; 2]> {
    debug_assert!(cost.better() == Better::Less, "a cost");
    let on = frontier(points, cost, Axis::Psnr);
    let kept = points.iter().zip(on).filter(|(_, on)| *on).map(|(point, _)| point);
    let place = |point| Some([cost.value(point)?, Axis::Psnr.value(point)?]);
    let mut curve: Vec<[f64; 2]> = kept.filter_map(place).collect();
    curve.sort_by(|a, b| a[0].total_cmp(&b[0]));
    curve.dedup();
    curve
}

/// How much more `method` costs than `anchor` at equal PSNR on average, per cent.
///
/// Both are curves of cost (above 0) and PSNR, dB, both strictly rising. `None` if one
/// has fewer than [`LEAST`] points or they share no range.
#[must_use]
pub fn bd_rate(anchor: &[[f64; 2]], method: &[[f64; 2]]) -> Option<f64> {
    let swapped = |curve: &[[f64; 2]]| curve.iter().map(|&[c, psnr]| [psnr, c.log10()]).collect();
    let difference = mean_difference(swapped(anchor), swapped(method))?;
    Some((10f64.powf(difference) - 1.0) * 100.0)
}

/// By how many dB the PSNR of `method` exceeds that of `anchor` at equal cost, on average
/// over the logarithm of the cost. Otherwise as [`bd_rate`].
#[must_use]
pub fn bd_psnr(anchor: &[[f64; 2]], method: &[[f64; 2]]) -> Option<f64> {
    let logarithm = |curve: &[[f64; 2]]| curve.iter().map(|&[c, psnr]| [c.log10(), psnr]).collect();
    mean_difference(logarithm(anchor), logarithm(method))
}

/// The mean of method minus anchor over the arguments that both have.
fn mean_difference(anchor: Vec<[f64; 2]>, method: Vec<[f64; 2]>) -> Option<f64> {
    let (anchor, method) = (Cubics::through(anchor)?, Cubics::through(method)?);
    let low = anchor.first().max(method.first());
    let high = anchor.last().min(method.last());
    let common = high - low;
    (common > 0.0).then(|| (method.integral(low, high) - anchor.integral(low, high)) / common)
}

/// A cubic between every two points, with slopes after Fritsch and Butland (1984): no
/// higher than the points, and monotone where they are.
struct Cubics {
    points: Vec<[f64; 2]>,
    slopes: Vec<f64>,
}

impl Cubics {
    /// Arguments must rise.
    fn through(points: Vec<[f64; 2]>) -> Option<Self> {
        let rises = |pair: &[[f64; 2]]| pair[0][0] < pair[1][0];
        if points.len() < LEAST || !points.windows(2).all(rises) {
            return None;
        }
        let steps: Vec<f64> = points.windows(2).map(|p| p[1][0] - p[0][0]).collect();
        let secants: Vec<f64> =
            points.windows(2).zip(&steps).map(|(p, h)| (p[1][1] - p[0][1]) / h).collect();
        let inner = steps.windows(2).zip(secants.windows(2)).map(|(h, s)| {
            if s[0] * s[1] <= 0.0 {
                return 0.0;
            }
            let (v, w) = (2.0 * h[1] + h[0], h[1] + 2.0 * h[0]);
            (v + w) / (v / s[0] + w / s[1])
        });
        let last = steps.len() - 1;
        let mut slopes = vec![end_slope([steps[0], steps[1]], [secants[0], secants[1]])];
        slopes.extend(inner);
        let (h, s) = ([steps[last], steps[last - 1]], [secants[last], secants[last - 1]]);
        slopes.push(end_slope(h, s));
        Some(Self { points, slopes })
    }

    fn first(&self) -> f64 {
        self.points[0][0]
    }

    fn last(&self) -> f64 {
        self.points[self.points.len() - 1][0]
    }

    /// The integral between two arguments.
    fn integral(&self, low: f64, high: f64) -> f64 {
        let pieces = self.points.windows(2).zip(self.slopes.windows(2));
        pieces
            .map(|(p, slope)| {
                let ([x0, y0], [x1, y1]) = (p[0], p[1]);
                let step = x1 - x0;
                let [from, to] = [low, high].map(|x| (x.clamp(x0, x1) - x0) / step);
                // Of Hermite's cubic, 0 to 1.
                let upto = |t: f64| {
                    let (t2, t3, t4) = (t * t, t * t * t, t * t * t * t);
                    y0 * (0.5 * t4 - t3 + t)
                        + step * slope[0] * (0.25 * t4 - 2.0 / 3.0 * t3 + 0.5 * t2)
                        + y1 * (t3 - 0.5 * t4)
                        + step * slope[1] * (0.25 * t4 - t3 / 3.0)
                };
                step * (upto(to) - upto(from))
            })
            .sum()
    }
}

/// The slope at an end by three points, kept from turning the curve around; the nearest
/// step and secant come first.
fn end_slope(h: [f64; 2], s: [f64; 2]) -> f64 {
    let slope = ((2.0 * h[0] + h[1]) * s[0] - h[0] * s[1]) / (h[0] + h[1]);
    if slope * s[0] <= 0.0 {
        0.0
    } else if s[0] * s[1] <= 0.0 && slope.abs() > 3.0 * s[0].abs() {
        3.0 * s[0]
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zip<const N: usize>(costs: [f64; N], psnr: [f64; N]) -> Vec<[f64; 2]> {
        costs.into_iter().zip(psnr).map(|(c, p)| [c, p]).collect()
    }

    /// `tests/fixtures/bjontegaard_reference.py`.
    #[test]
    fn as_another_program_says() {
        let cases = [
            (
                zip([10.0, 20.0, 40.0, 90.0], [28.0, 31.0, 33.2, 34.0]),
                zip([8.0, 17.0, 33.0, 70.0], [28.3, 31.1, 33.4, 34.4]),
                [-21.714446549317035, 0.7130416496366375],
            ),
            (
                zip([85.95, 157.11, 309.58, 686.76], [31.42, 34.24, 37.18, 40.28]),
                zip([112.75, 204.93, 407.8, 893.34], [31.24, 34.17, 37.21, 40.39]),
                [31.379878202397627, -1.1834724046224592],
            ),
            (
                zip([1.0, 2.0, 3.0, 50.0, 60.0], [20.0, 20.1, 27.0, 27.2, 30.0]),
                zip([1.5, 2.5, 9.0, 30.0], [18.0, 25.0, 26.0, 31.0]),
                [-16.840716481386742, 0.04283773356963671],
            ),
        ];
        for (anchor, method, [rate, psnr]) in cases {
            let found = [bd_rate(&anchor, &method), bd_psnr(&anchor, &method)];
            assert!((found[0].unwrap() - rate).abs() < 1e-9, "{found:?} {rate}");
            assert!((found[1].unwrap() - psnr).abs() < 1e-9, "{found:?} {psnr}");
        }
    }

    #[test]
    fn without_four_points_or_a_common_range_there_is_none() {
        let four = zip([1.0, 2.0, 3.0, 4.0], [20.0, 21.0, 22.0, 23.0]);
        let above = zip([1.0, 2.0, 3.0, 4.0], [30.0, 31.0, 32.0, 33.0]);
        assert_eq!(bd_rate(&four, &four[..3]), None);
        assert_eq!(bd_rate(&four, &above), None);
        assert!((bd_psnr(&four, &above).unwrap() - 10.0).abs() < 1e-12);
        let falling = zip([1.0, 2.0, 3.0, 4.0], [20.0, 21.0, 20.5, 23.0]);
        assert_eq!(bd_rate(&four, &falling), None);
    }

    #[test]
    fn series_of_a_group_are_compared_along_their_frontiers() {
        let point = |method: &str, ms: f64, psnr: f64| Point {
            program: super::super::OURS.to_owned(),
            method: method.to_owned(),
            ms_per_frame: Some(ms),
            psnr: Some(psnr),
            ..Point::default()
        };
        let mut points: Vec<Point> = [(1.0, 20.0), (2.0, 21.0), (4.0, 22.0), (8.0, 23.0)]
            .into_iter()
            .flat_map(|(ms, psnr)| [point("a", ms, psnr), point("b", 2.0 * ms, psnr)])
            .collect();
        // Dominated points are ignored.
        points.push(point("a", 100.0, 10.0));
        let found = compare(&points, Axis::MsPerFrame);
        let [only] = &found[..] else { panic!("{found:?}") };
        assert_eq!((&*only.anchor, &*only.method), ("a", "b"));
        assert!((only.bd_rate.unwrap() - 100.0).abs() < 1e-9, "{only:?}");
    }
}
