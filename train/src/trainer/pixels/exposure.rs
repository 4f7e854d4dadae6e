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
}

impl Exposure {
    /// Photographs are multiplied by these gains, one a view and channel.
    pub(crate) fn new(gains: Vec<[f32; 3]>) -> Self {
        let table = |gain: f32| {
            let gain = gain.clamp(1.0 / MOST, MOST);
            core::array::from_fn(|value| (gain * value as f32).round().min(255.0) as u8)
        };
        let tables = gains.iter().map(|gains| gains.map(table)).collect();
        Self { gains, tables }
    }

    /// One a view; empty where photographs are taken as they are.
    pub(crate) fn gains(&self) -> &[[f32; 3]] {
        &self.gains
    }

    /// Whether a pixel of a view hides how bright the scene is: where there was too much light
    /// for the photograph, but not for darker ones.
    #[inline]
    pub(crate) fn is_cut_off(&self, view: usize, rgba: [u8; 4]) -> bool {
        let gains = self.gains.get(view);
        gains.is_some_and(|gains| (0..3).any(|c| rgba[c] == u8::MAX && gains[c] < DARKENED))
    }

    /// A pixel of a view, evened out.
    #[inline]
    pub(crate) fn even(&self, view: usize, rgba: [u8; 4]) -> [u8; 4] {
        let Some([red, green, blue]) = self.tables.get(view) else { return rgba };
        let [r, g, b, a] = rgba;
        [red[usize::from(r)], green[usize::from(g)], blue[usize::from(b)], a]
    }
}
