//! Settings of training runs: a kind of field, and how much detail a run of some length can learn.

use pocketnerf_core::space::Contracted;

use crate::field::{
    FieldConfig, HashGridFieldConfig, NerfConfig, PlanesConfig, PlanesFieldConfig, Training,
};
use crate::trainer::{Length, TrainConfig, USUAL_SAMPLES};

/// Samples along the longest side in a run of a minute or less.
const SAMPLES: f32 = 350.0;

impl TrainConfig {
    /// A weight of [`smooth_surfaces`](Self::smooth_surfaces) for photographs without alpha, which
    /// are of places: surfaces of one colour are where they belong, with less fog before them. Not
    /// where 3-D points tell how near a scene around its cameras comes: what is fog near a camera
    /// then may become a wall.
    pub const SMOOTH_PLACES: f32 = 0.02;

    /// The defaults for a field of this kind and shape.
    #[must_use]
    pub fn new(field: impl Into<FieldConfig>) -> Self {
        let field = field.into();
        let Training {
            occupancy_resolution,
            samples_per_side,
            batch_rays,
            grid_rate,
            grid_decay,
            grid_smoothing: _,
            network_rate,
            kept,
            first_step_scale,
            least_steps: _,
        } = field.kind().training();
        Self {
            field,
            seed: 0,
            aabb: None,
            ndc: None,
            contracted: None,
            near: 0.0,
            far: None,
            occupancy_resolution,
            samples_per_side,
            batch_rays,
            samples_per_step: USUAL_SAMPLES,
            grid_rate,
            grid_decay,
            network_rate,
            final_rate: 0.1,
            kept,
            first_step_scale,
            opaque_backdrop: [0.0; 3],
            backdrop: None,
            smooth_surfaces: 0.0,
            clear_fog: false,
            refine_poses: false,
        }
    }

    /// What suits most scenes on a CPU: of an object, in a box and in photographs with alpha,
    /// planes and lines, which are better in the same time and take half the bytes; of a place a
    /// hash grid.
    #[must_use]
    pub fn usual(is_object: bool, pixels: f32) -> Self {
        if is_object { Self::planes(pixels) } else { Self::hash_grid() }
    }

    /// The defaults of planes and lines for photographs of so many pixels across:
    /// [`Dataset::pixels_across`](crate::dataset::Dataset::pixels_across).
    #[must_use]
    pub fn planes(pixels: f32) -> Self {
        let usual = PlanesFieldConfig::default();
        let resolution = PlanesConfig::resolution_for(pixels);
        let grid = PlanesConfig::new(resolution, usual.grid.n_components);
        Self::new(PlanesFieldConfig { grid, ..usual })
    }

    /// The hash-grid method's defaults.
    #[must_use]
    pub fn hash_grid() -> Self {
        Self::new(HashGridFieldConfig::default())
    }

    /// Those of a vanilla NeRF that is trained in occupied cells alone.
    #[must_use]
    pub fn nerf() -> Self {
        Self::new(NerfConfig::in_cells())
    }

    /// With as much detail as a run of this length can learn: shorter steps, and
    /// for runs of more than a minute and a half a wider colour network, on a machine that
    /// takes 110 steps a second. How many this one takes, [`Trainer::pace`] measures.
    ///
    /// [`Trainer::pace`]: crate::trainer::Trainer::pace
    #[must_use]
    pub fn for_length(mut self, length: Length) -> Self {
        self.samples_per_side = (SAMPLES * finer(length)).clamp(SAMPLES, 800.0).round();
        if let (Some([_, color]), true) = (self.field.hidden_mut(), seconds(length) > 90.0) {
            *color = vec![128, 128];
        }
        self
    }

    /// In contracted space, for a run of this length: to be called last. The cube is half as wide as
    /// all of that space. In a run of a minute or more its samples lie as close as those of a box of
    /// its size, in shorter ones, which need the rays more, up to twice as far apart.
    #[must_use]
    pub fn contracted(mut self, space: Contracted, length: Length) -> Self {
        self.contracted = Some(space);
        if self.field.hidden_mut().is_some() {
            let usual = self.samples_per_side;
            let twice = 2.0 * SAMPLES * finer(length);
            self.samples_per_side = twice.clamp(usual, 2.0 * usual).round();
        }
        self
    }

    /// For models that render one and a half times as fast: longer steps, narrower networks and, of
    /// a hash grid, eight levels, however long the run.
    #[must_use]
    pub fn for_speed(mut self) -> Self {
        self.samples_per_side = 300.0;
        if let Some([density, color]) = self.field.hidden_mut() {
            *density = vec![32];
            *color = vec![64, 64];
        }
        if let Some(field) = self.field.hash_grid_mut() {
            field.color_hidden = vec![32, 32];
            // As fine as nine levels 1.65 times finer each.
            (field.grid.n_levels, field.grid.per_level_scale) = (8, 1.77);
        }
        self
    }
}

/// How long a run is, seconds on a machine that takes 110 steps a second.
fn seconds(length: Length) -> f32 {
    (length.about_steps() / Length::PACE) as f32
}

/// How many times closer samples are than in a run of a minute: twice for eight times the time,
/// about.
fn finer(length: Length) -> f32 {
    (seconds(length) / 60.0).powf(0.35)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_follow_the_pixels() {
        let entries = |pixels| match TrainConfig::usual(true, pixels).field {
            FieldConfig::Planes(field) => field.grid.last_resolution,
            other => unreachable!("{other:?}"),
        };
        assert_eq!([25.0, 50.0, 199.6, 800.0].map(entries), [32, 50, 200, 300]);
        assert_eq!(TrainConfig::usual(false, 50.0), TrainConfig::hash_grid());
    }

    #[test]
    fn detail_follows_the_time() {
        let at = |length| TrainConfig::hash_grid().for_length(length);
        assert_eq!(at(Length::Seconds(5.0)), TrainConfig::hash_grid());
        assert_eq!(at(Length::Seconds(60.0)).samples_per_side, 350.0);
        assert_eq!(at(Length::Steps(33_000)), at(Length::Seconds(300.0)));
        assert_eq!(at(Length::Seconds(300.0)).samples_per_side, 615.0);
        assert_eq!(at(Length::Seconds(1e6)).samples_per_side, 800.0);
        let around = Contracted { center: [0.0; 3], radius: 1.0 };
        for (seconds, samples) in [(5.0, 350.0), (30.0, 549.0), (60.0, 700.0), (1e6, 1600.0)] {
            let length = Length::Seconds(seconds);
            assert_eq!(at(length).contracted(around, length).samples_per_side, samples);
        }
        let (nerf, long) = (TrainConfig::nerf(), Length::Seconds(300.0));
        let same = nerf.clone().contracted(around, long).samples_per_side;
        assert_eq!(same, nerf.samples_per_side, "its networks are costly");
        let mut long = at(Length::Seconds(91.0));
        assert_eq!(long.field.hash_grid_mut().unwrap().color_hidden, [128, 128]);
        // Speed does not.
        let short = at(Length::Seconds(5.0)).for_speed();
        assert_eq!(at(Length::Seconds(1e6)).for_speed(), short);
        assert!(short.samples_per_side < at(Length::Seconds(5.0)).samples_per_side);
        // Of planes, colours keep their networks.
        let mut planes = TrainConfig::planes(800.0).for_length(Length::Seconds(300.0)).for_speed();
        let [density, color] = planes.field.hidden_mut().unwrap();
        assert_eq!([&density[..], color], [&[32][..], &[64, 64]]);
        // Fewer levels, and the finest as fine.
        let finest = |mut config: TrainConfig| {
            let grid = config.field.hash_grid_mut().unwrap().grid;
            grid.level(grid.n_levels as usize - 1).scale
        };
        let [fine, fast] = [TrainConfig::hash_grid(), short].map(finest);
        assert!((fast / fine - 1.0).abs() < 0.02, "{fine} {fast}");
    }
}
