//! Settings of training runs: a method, and how much detail a run of some length can learn.

use pocketnerf_core::field::Activation;

use crate::field::{
    DerfConfig, FieldConfig, HashGridFieldConfig, HierarchicalTraining, NerfConfig,
    PlanesFieldConfig, PlenoxelsConfig,
};
use crate::trainer::{Length, TrainConfig, USUAL_SAMPLES};

impl TrainConfig {
    /// The hash-grid method's defaults.
    #[must_use]
    pub fn hash_grid() -> Self {
        Self {
            field: FieldConfig::HashGrid(HashGridFieldConfig::default()),
            seed: 0,
            aabb: None,
            ndc: None,
            contracted: None,
            near: 0.0,
            far: None,
            occupancy_resolution: 128,
            samples_per_side: 350.0,
            batch_rays: None,
            samples_per_step: USUAL_SAMPLES,
            grid_rate: 2e-2,
            grid_decay: 350.0,
            network_rate: 2e-2,
            final_rate: 0.1,
            kept: [0.1, 0.5],
            first_step_scale: 2.5,
            opaque_backdrop: [0.0; 3],
            backdrop: None,
            smooth_surfaces: 0.0,
            refine_poses: false,
        }
    }

    /// A sparse grid of voxels, as in Plenoxels.
    #[must_use]
    pub fn plenoxels() -> Self {
        Self {
            field: FieldConfig::Plenoxels(PlenoxelsConfig::default()),
            samples_per_side: 384.0,
            grid_rate: 5e-2,
            grid_decay: 0.0,
            kept: [0.3, 0.5],
            first_step_scale: 1.5,
            ..Self::hash_grid()
        }
    }

    /// Planes and lines, as in TensoRF.
    #[must_use]
    pub fn planes() -> Self {
        Self {
            field: FieldConfig::Planes(PlanesFieldConfig::default()),
            grid_decay: 0.0,
            ..Self::hash_grid()
        }
    }

    /// A vanilla NeRF, trained in occupied cells alone: what a CPU can do in minutes.
    #[must_use]
    pub fn nerf() -> Self {
        let nerf = NerfConfig {
            coarse: false,
            activation: Activation::Exp,
            muon: true,
            ..NerfConfig::vanilla()
        };
        Self {
            field: FieldConfig::Nerf(nerf),
            occupancy_resolution: 64,
            samples_per_side: 128.0,
            batch_rays: Some(4096),
            kept: [0.5; 2],
            first_step_scale: 1.0,
            network_rate: 4e-3,
            ..Self::hash_grid()
        }
    }

    /// Small vanilla NeRFs for parts of a scene, as in DeRF.
    #[must_use]
    pub fn derf() -> Self {
        Self { field: FieldConfig::Derf(DerfConfig::default()), ..Self::nerf() }
    }

    /// A vanilla NeRF, trained by hierarchical sampling.
    #[must_use]
    pub fn hierarchical(training: HierarchicalTraining) -> Self {
        let nerf = NerfConfig { hierarchical: Some(training), ..NerfConfig::vanilla() };
        Self {
            field: FieldConfig::Nerf(nerf),
            network_rate: 5e-4,
            samples_per_side: 256.0,
            ..Self::nerf()
        }
    }

    /// With as much detail as a run of this length can learn: shorter steps, and
    /// for runs of more than a minute and a half a wider colour network, on a machine that
    /// takes 110 steps a second. How many this one takes, [`Trainer::pace`] measures.
    ///
    /// [`Trainer::pace`]: crate::trainer::Trainer::pace
    #[must_use]
    pub fn for_length(mut self, length: Length) -> Self {
        let seconds = (length.about_steps() / Length::PACE) as f32;
        // Twice the samples for eight times the time, about.
        let finer = (seconds / 60.0).powf(0.35);
        self.samples_per_side = (350.0 * finer).clamp(350.0, 800.0).round();
        let color_hidden = match &mut self.field {
            FieldConfig::HashGrid(field) => Some(&mut field.color_hidden),
            FieldConfig::Planes(field) => Some(&mut field.color_hidden),
            _ => None,
        };
        if let (Some(hidden), true) = (color_hidden, seconds > 90.0) {
            *hidden = vec![128, 128];
        }
        self
    }

    /// For models that render twice as fast: longer steps, narrower networks and eight
    /// levels of the grid, however long the run.
    #[must_use]
    pub fn for_speed(mut self) -> Self {
        self.samples_per_side = 300.0;
        if let Some(field) = self.field.hash_grid_mut() {
            field.density_hidden = vec![32];
            field.color_hidden = vec![32, 32];
            // As fine as nine levels 1.65 times finer each.
            (field.grid.n_levels, field.grid.per_level_scale) = (8, 1.77);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detail_follows_the_time() {
        let at = |length| TrainConfig::hash_grid().for_length(length);
        assert_eq!(at(Length::Seconds(5.0)), TrainConfig::hash_grid());
        assert_eq!(at(Length::Seconds(60.0)).samples_per_side, 350.0);
        assert_eq!(at(Length::Steps(33_000)), at(Length::Seconds(300.0)));
        assert_eq!(at(Length::Seconds(300.0)).samples_per_side, 615.0);
        assert_eq!(at(Length::Seconds(1e6)).samples_per_side, 800.0);
        let mut long = at(Length::Seconds(91.0));
        assert_eq!(long.field.hash_grid_mut().unwrap().color_hidden, [128, 128]);
        // Speed does not.
        let short = at(Length::Seconds(5.0)).for_speed();
        assert_eq!(at(Length::Seconds(1e6)).for_speed(), short);
        assert!(short.samples_per_side < at(Length::Seconds(5.0)).samples_per_side);
        // Fewer levels, and the finest as fine.
        let finest = |mut config: TrainConfig| {
            let grid = config.field.hash_grid_mut().unwrap().grid;
            grid.level(grid.n_levels as usize - 1).scale
        };
        let [fine, fast] = [TrainConfig::hash_grid(), short].map(finest);
        assert!((fast / fine - 1.0).abs() < 0.02, "{fine} {fast}");
    }
}
