//! Photographs that are brighter or of another colour than the others are evened out.

/// Gains beyond these are taken for these.
const MOST: f32 = 16.0;
/// What is as bright as can be becomes visibly darker by gains below this.
const DARKENED: f32 = 0.95;

/// A factor for each channel of each view, by which its photograph is as bright as the others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Exposure {
    gains: Vec<[f32; 3]>,
    /// What becomes of each value of each channel.
    tables: Vec<[[u8; 256]; 3]>,
    /// By how much the scene is brighter in each view than the gains say; empty where that is not
    /// learnt.
    factors: Vec<[f32; 3]>,
}

impl Exposure {
    /// Photographs are multiplied by these gains, one a view and channel.
    pub(crate) fn new(gains: Vec<[f32; 3]>) -> Self {
        let table = |gain: f32| {
            let gain = gain.clamp(1.0 / MOST, MOST);
            core::array::from_fn(|value| (gain * value as f32).round().min(255.0) as u8)
        };
        let tables = gains.iter().map(|gains| gains.map(table)).collect();
        Self { gains, tables, factors: Vec::new() }
    }

    /// By how much the scene is brighter in each view than the gains say.
    pub(crate) fn set_factors(&mut self, factors: Vec<[f32; 3]>) {
        self.factors = factors;
    }

    /// Those of a view, where they are learnt.
    #[inline]
    pub(crate) fn factors(&self, view: usize) -> Option<[f32; 3]> {
        self.factors.get(view).copied()
    }

    /// One a view; empty where photographs are taken as they are.
    pub(crate) fn gains(&self) -> &[[f32; 3]] {
        &self.gains
    }

    /// Of which channels of a pixel of a view only the least value is known: there was too much
    /// light for the photograph, but not for darker ones.
    #[inline]
    pub(crate) fn at_least(&self, view: usize, rgba: [u8; 4]) -> [bool; 3] {
        let Some(gains) = self.gains.get(view) else { return [false; 3] };
        // What is transparent has no colour that could be too bright.
        [0, 1, 2].map(|c| rgba[3] > 0 && rgba[c] == u8::MAX && gains[c] < DARKENED)
    }

    /// A pixel of a view, evened out.
    #[inline]
    pub(crate) fn even(&self, view: usize, rgba: [u8; 4]) -> [u8; 4] {
        let Some([red, green, blue]) = self.tables.get(view) else { return rgba };
        let [r, g, b, a] = rgba;
        [red[usize::from(r)], green[usize::from(g)], blue[usize::from(b)], a]
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::{Camera, Space};

    use super::*;
    use crate::dataset::View;
    use crate::random::Random;
    use crate::trainer::Backdrop;
    use crate::trainer::pixels::rays::{Pixel, RaySource};
    use crate::trainer::pixels::visibility::PixelVisibility;

    #[test]
    fn by_hand() {
        let exposure = Exposure::new(vec![[0.5, 1.0, 2.0], [1.0; 3]]);
        assert_eq!(exposure.even(0, [101, 60, 200, 7]), [51, 60, 255, 7]);
        assert_eq!(exposure.even(1, [101, 60, 200, 7]), [101, 60, 200, 7]);
        assert_eq!(Exposure::default().even(0, [1, 2, 3, 4]), [1, 2, 3, 4]);
        // Red was cut off, green and blue are not darkened.
        assert_eq!(exposure.at_least(0, [255; 4]), [true, false, false]);
        assert_eq!(exposure.at_least(0, [255, 0, 0, 9]), [true, false, false]);
        for rgba in
            [[254; 4], [254, 255, 255, 9], [0, 255, 255, 9], [255, 0, 0, 0], [255, 255, 255, 0]]
        {
            assert_eq!(exposure.at_least(0, rgba), [false; 3], "{rgba:?}");
        }
        assert_eq!(exposure.at_least(1, [255; 4]), [false; 3]);
        assert_eq!(Exposure::default().at_least(0, [255; 4]), [false; 3]);
    }

    #[test]
    fn what_was_cut_off_is_drawn_as_the_least_value() {
        let pose = Camera::look_at([3.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(24, 24, 0.5, pose);
        let is_bright = |i: u32| i.is_multiple_of(5);
        let rgba = (0..24 * 24).flat_map(|i| [if is_bright(i) { 255 } else { 90 }, 90, 90, 255]);
        let view = View::new("", camera, rgba.collect());
        let mut source = RaySource::new(vec![view.clone(), view], Backdrop::Random);
        source.even_out(vec![[0.8; 3], [1.25; 3]]);
        let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        let visibility = PixelVisibility::new(&source, &space, 32, &[]);
        let mut random = Random::new(1, [0; 3]);
        for (view, i) in (0..2).flat_map(|view| (0..24 * 24).map(move |i| (view, i))) {
            let (pixel, is_cut_off) =
                (Pixel { view, x: i % 24, y: i / 24 }, view == 0 && is_bright(i));
            assert!(visibility.draws(pixel), "{pixel:?}");
            assert_eq!(source.is_exact(view as usize, i as usize), !is_cut_off, "{pixel:?}");
            let ray = source.ray(pixel, source.rgba(pixel), (0, 1.0), &mut random);
            assert_eq!(ray.at_least, [is_cut_off, false, false], "{pixel:?}");
            let least = if is_cut_off { 0.8 } else { ray.target[0] };
            assert!((ray.target[0] - least).abs() < 1e-6, "{pixel:?}");
        }
    }
}
