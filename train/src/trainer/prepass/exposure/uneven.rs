//! What differs from photograph to photograph, and not from side to side: light that depends on
//! the direction changes slowly from camera to camera.

use glam::Vec3;
use pocketnerf_core::Camera;

use super::Ratio;
use crate::cameras::spacing;
use crate::metrics::{mean, median};

/// Neighbours of a camera that it is compared with.
const AROUND: usize = 6;
/// Photographs differ where they do by more than this share, as a standard deviation ...
const SHARE: f64 = 0.02;
/// ... and by this part of what pixels of a photograph differ by among each other: of mirrors and
/// foliage a field without view dependence shows each part wrong.
const OF_PIXELS: f64 = 0.18;
/// Of cameras farther apart than this, degrees, neighbours do not see the same.
const APART: f32 = 21.0;
/// The standard deviation of a normal distribution beside its median size.
const NORMAL: f64 = 1.4826;

/// The nearest cameras of each.
#[derive(Debug)]
pub(super) struct Neighbours(Vec<Vec<usize>>);

impl Neighbours {
    /// `None` where they are too few or too far apart to see the same.
    pub(super) fn new(cameras: &[Camera]) -> Option<Self> {
        if cameras.len() <= AROUND || spacing(cameras)? > APART {
            return None;
        }
        let places: Vec<Vec3> = cameras.iter().map(|camera| camera.position().into()).collect();
        let nearest = |own: usize| {
            let away = |i: &usize| places[*i].distance(places[own]);
            let mut others: Vec<usize> = (0..places.len()).filter(|i| *i != own).collect();
            others.select_nth_unstable_by(AROUND - 1, |a, b| away(a).total_cmp(&away(b)));
            others.truncate(AROUND);
            others.sort_unstable();
            others
        };
        Some(Self((0..places.len()).map(nearest).collect()))
    }
}

/// How one channel differs.
#[derive(Debug)]
pub(super) struct Uneven {
    /// Logarithms of the gains that make the views alike, their mean 0.
    pub(super) logs: Vec<f64>,
    /// Standard deviation of these among neighbours.
    pub(super) spread: f64,
    /// The usual distance between the quartiles of the pixels of a view.
    pixels: f64,
}

impl Uneven {
    /// From the ratio of each view. What neighbours share is taken for the scene's light, as far
    /// as it is more than chance (Wiener's filter).
    pub(super) fn new(neighbours: &Neighbours, ratios: &[Ratio]) -> Self {
        let known = ratios.iter().flatten().map(|[log, _]| *log);
        let middle = mean(known).unwrap_or(0.0);
        let logs: Vec<f64> =
            ratios.iter().map(|ratio| ratio.map_or(0.0, |[log, _]| log - middle)).collect();
        let local = |around: &Vec<usize>| mean(around.iter().map(|i| logs[*i])).unwrap_or(0.0);
        let local: Vec<f64> = neighbours.0.iter().map(local).collect();
        // The mean of k neighbours differs too, by a k-th of the variance.
        let k = AROUND as f64;
        let off =
            || logs.iter().zip(&local).map(|(log, local)| (log - local).powi(2) * k / (k + 1.0));
        let (own, all) =
            (mean(off()).unwrap_or(0.0), mean(logs.iter().map(|log| log * log)).unwrap_or(0.0));
        let shared = (all - own).max(0.0);
        let weight = if shared > 0.0 { shared / (shared + own / k) } else { 0.0 };
        let pixels = median(ratios.iter().flatten().map(|[_, pixels]| *pixels)).unwrap_or(0.0);
        Self {
            spread: NORMAL * median(off().map(f64::sqrt)).unwrap_or(0.0),
            logs: logs.iter().zip(&local).map(|(log, local)| log - weight * local).collect(),
            pixels,
        }
    }

    /// Whether the photographs themselves differ.
    pub(super) fn is_more_than_chance(&self) -> bool {
        self.spread > SHARE.max(OF_PIXELS * self.pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Cameras on a circle.
    fn circle() -> Vec<Camera> {
        let pose = |i: usize| {
            let angle = i as f32 / 60.0 * core::f32::consts::TAU;
            Camera::look_at([angle.cos(), angle.sin(), 0.5], [0.0; 3], [0.0, 0.0, 1.0])
        };
        (0..60).map(|i| Camera::from_fov_x(8, 8, 0.7, pose(i))).collect()
    }

    #[test]
    fn light_from_one_side_is_no_exposure() {
        let neighbours = Neighbours::new(&circle()).unwrap();
        let ratio = |log: f64| Some([log, 0.1]);
        let side = |i: usize| 0.2 * (i as f64 / 60.0 * core::f64::consts::TAU).sin();
        let lit: Vec<Ratio> = (0..60).map(|i| ratio(side(i))).collect();
        let found = Uneven::new(&neighbours, &lit);
        assert!(!found.is_more_than_chance(), "{}", found.spread);
        assert!(found.logs.iter().all(|log| log.abs() < 0.03), "{:?}", found.logs);
        // Photographs that differ, on top of it: they are what is found.
        let mut random = Random::new(1, [0; 3]);
        let own: Vec<f64> = (0..60).map(|_| 0.3 * (f64::from(random.next_f32()) - 0.5)).collect();
        let both: Vec<Ratio> = (0..60).map(|i| ratio(side(i) + own[i])).collect();
        let found = Uneven::new(&neighbours, &both);
        assert!(found.is_more_than_chance(), "{}", found.spread);
        let middle = own.iter().sum::<f64>() / 60.0;
        let off = own.iter().zip(&found.logs).map(|(own, log)| (own - middle - log).powi(2));
        let left = mean(off).unwrap().sqrt();
        assert!(left < 0.045, "{left} of 0.087");
        // Among few cameras light from one side cannot be told from exposure.
        let far: Vec<Camera> = circle().into_iter().step_by(5).collect();
        assert!(Neighbours::new(&circle()[..6]).is_none() && Neighbours::new(&far).is_none());
        // A view of which nothing is known is left as it is.
        let unknown: Vec<Ratio> = vec![None; 60];
        assert!(Uneven::new(&neighbours, &unknown).logs.iter().all(|log| *log == 0.0));
    }

    #[test]
    fn where_pixels_differ_anyway_more_is_needed() {
        let neighbours = Neighbours::new(&circle()).unwrap();
        let mut random = Random::new(1, [0; 3]);
        let own: Vec<f64> = (0..60).map(|_| 0.2 * (f64::from(random.next_f32()) - 0.5)).collect();
        for (pixels, differ) in [(0.1, true), (0.5, false)] {
            let ratios: Vec<Ratio> = own.iter().map(|own| Some([*own, pixels])).collect();
            assert_eq!(Uneven::new(&neighbours, &ratios).is_more_than_chance(), differ, "{pixels}");
        }
    }
}
