//! Settings of a training run.

use pocketnerf_core::encoding::{GridIndex, HashGridConfig};
use pocketnerf_core::field::{Activation, Shading};
use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::space::Ndc;

use super::{Adam, Length};
use crate::field::{EncodingConfig, FieldConfig, NerfConfig};

/// Everything that decides what a run learns, apart from its data and length.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainConfig {
    /// Shape of the field.
    pub field: FieldConfig,
    /// Where random numbers begin.
    pub seed: u64,
    /// The box of the scene, smallest and largest corner; `None`: the dataset's, or, where
    /// it has none, found from the cameras, the silhouettes and a small field. A trainer's
    /// own is never `None`.
    pub aabb: Option<[[f32; 3]; 2]>,
    /// `Some`: a forward-facing capture, learnt in normalised device coordinates; there
    /// is no box in scene units then. [`ndc_of`](super::ndc_of) finds them.
    pub ndc: Option<Ndc>,
    /// Nothing is seen nearer to a camera than this, local units.
    pub near: f32,
    /// Nothing is seen farther than this; `None`: everything in the box.
    pub far: Option<f32>,
    /// Cells of the occupancy along an axis.
    pub occupancy_resolution: u32,
    /// Samples along the longest side of the box.
    pub samples_per_side: f32,
    /// Rays a step; `None`: as many as give `samples_per_step`.
    pub batch_rays: Option<usize>,
    /// Samples a step aims at.
    pub samples_per_step: usize,
    /// Learning rate of grid entries at its highest.
    pub grid_rate: f32,
    /// Decay of grid entries, see [`Adam::decay`](super::Adam::decay),
    /// summed over the steps of a run: what some training views ask for and others
    /// do not is forgotten.
    pub grid_decay: f32,
    /// Learning rate of network weights at its highest.
    pub network_rate: f32,
    /// What remains of the learning rates at the end.
    pub final_rate: f32,
    /// Share of samples that the roulette passes back, at the start and at the
    /// end; 1: all.
    pub kept: [f32; 2],
    /// Steps are so many times longer at the start.
    pub first_step_scale: f32,
    /// Colour behind images without alpha.
    pub opaque_backdrop: [f32; 3],
    /// `Some`: learn against this background, not against what random ones give on average.
    pub backdrop: Option<[f32; 3]>,
    /// Whether a field of networks alone learns by Muon at first, as those beside a grid
    /// do; else by Adam.
    pub orthogonal: bool,
    /// The paper's sampling, in place of marching through occupied cells.
    pub paper: Option<Paper>,
}

/// Training as in the paper (Mildenhall et al. 2020, section 5.3): rays from all pixels,
/// stratified and hierarchical samples, the error of both networks, and nothing of what
/// else this program does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paper {
    /// How many samples.
    pub sampling: Hierarchical,
    /// Standard deviation of what is added to the network's density at random.
    pub noise: f32,
    /// In so many first steps rays come from the middle halves of the images.
    pub crop_steps: u32,
}

impl Paper {
    /// 64 + 128 samples, no noise, no crop.
    pub const PLAIN: Self = Self {
        sampling: Hierarchical { reach: Reach::Clipped, ..Hierarchical::PAPER },
        noise: 0.0,
        crop_steps: 0,
    };
}

impl TrainConfig {
    /// The hash-grid method's defaults.
    #[must_use]
    pub fn hash_grid() -> Self {
        let grid = HashGridConfig {
            n_levels: 9,
            n_features_per_level: 4,
            log2_hashmap_size: 17,
            base_resolution: 16,
            per_level_scale: 1.65,
            index: GridIndex::Blocked,
        };
        Self {
            field: FieldConfig {
                encoding: EncodingConfig::HashGrid(grid),
                density_hidden: vec![64],
                color_hidden: vec![64, 64],
                n_features: 15,
                sh_degree: 4,
                shading: Shading::PerRay,
                log_density_bias: 0.0,
            },
            seed: 0,
            aabb: None,
            ndc: None,
            near: 0.0,
            far: None,
            occupancy_resolution: 128,
            samples_per_side: 350.0,
            batch_rays: None,
            samples_per_step: 1 << 15,
            grid_rate: 2e-2,
            grid_decay: 350.0,
            network_rate: 2e-2,
            final_rate: 0.1,
            kept: [0.1, 0.5],
            first_step_scale: 2.5,
            opaque_backdrop: [0.0; 3],
            backdrop: None,
            orthogonal: false,
            paper: None,
        }
    }

    /// The paper's field, trained in occupied cells alone: what a CPU can do in minutes.
    #[must_use]
    pub fn nerf() -> Self {
        let nerf = NerfConfig { coarse: false, activation: Activation::Exp, ..NerfConfig::paper() };
        let mut config = Self::hash_grid();
        config.field.encoding = EncodingConfig::Nerf(nerf);
        Self {
            occupancy_resolution: 64,
            samples_per_side: 128.0,
            batch_rays: Some(4096),
            kept: [0.5; 2],
            first_step_scale: 1.0,
            network_rate: 4e-3,
            orthogonal: true,
            ..config
        }
    }

    /// The paper's field, trained as in the paper.
    #[must_use]
    pub fn paper(paper: Paper) -> Self {
        let mut config = Self::nerf();
        config.field.encoding = EncodingConfig::Nerf(NerfConfig::paper());
        Self {
            paper: Some(paper),
            network_rate: 5e-4,
            orthogonal: false,
            samples_per_side: 256.0,
            ..config
        }
    }

    /// How the paper's sampling asks the model: as in training, or with its numbers.
    pub(super) fn hierarchical(&self) -> Option<Hierarchical> {
        let paper = self.paper.unwrap_or(Paper::PLAIN).sampling;
        self.nerf_field().map(|_| paper)
    }

    /// The constants of Adam.
    pub(super) fn adam(&self) -> Adam {
        let Some(_) = self.paper else { return Adam::default() };
        // The paper's. Its gradient is that of the mean squared error, ours that of half
        // the sum.
        let mean = 1.5 * self.batch_rays.unwrap_or(1) as f32;
        Adam { beta1: 0.9, beta2: 0.999, epsilon: 1e-7 * mean, decay: 0.0 }
    }

    /// The paper's field, where it is this.
    #[must_use]
    pub fn nerf_field(&self) -> Option<&NerfConfig> {
        match &self.field.encoding {
            EncodingConfig::Nerf(nerf) => Some(nerf),
            _ => None,
        }
    }

    /// Whether asking the field takes a thousand times as long as asking a grid.
    pub(super) fn is_dear(&self) -> bool {
        self.nerf_field().is_some()
    }

    /// With as much detail as a run of this length can learn: shorter steps, and
    /// for runs of more than a minute and a half a wider colour network. A
    /// second counts as 110 steps.
    #[must_use]
    pub fn for_length(mut self, length: Length) -> Self {
        let seconds = match length {
            Length::Seconds(seconds) => seconds as f32,
            Length::Steps(steps) => steps as f32 / 110.0,
        };
        // Twice the samples for eight times the time, about.
        let finer = (seconds / 60.0).powf(0.35);
        self.samples_per_side = (350.0 * finer).clamp(350.0, 800.0).round();
        if seconds > 90.0 {
            self.field.color_hidden = vec![128, 128];
        }
        self
    }

    /// For models whose pictures take half the time: longer steps, narrower networks
    /// and eight levels of the grid, however long the run.
    #[must_use]
    pub fn for_speed(mut self) -> Self {
        self.samples_per_side = 300.0;
        self.field.density_hidden = vec![32];
        self.field.color_hidden = vec![32, 32];
        if let EncodingConfig::HashGrid(grid) = &mut self.field.encoding {
            // As fine as nine levels 1.65 times finer each.
            (grid.n_levels, grid.per_level_scale) = (8, 1.77);
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
        assert_eq!(at(Length::Seconds(91.0)).field.color_hidden, [128, 128]);
        // Speed does not.
        let short = at(Length::Seconds(5.0)).for_speed();
        assert_eq!(at(Length::Seconds(1e6)).for_speed(), short);
        assert!(short.samples_per_side < at(Length::Seconds(5.0)).samples_per_side);
        // Fewer levels, and the finest as fine.
        let finest = |config: &TrainConfig| match config.field.encoding {
            EncodingConfig::HashGrid(grid) => grid.level(grid.n_levels as usize - 1).scale,
            _ => unreachable!("a hash grid"),
        };
        let [fine, fast] = [&TrainConfig::hash_grid(), &short].map(finest);
        assert!((fast / fine - 1.0).abs() < 0.02, "{fine} {fast}");
    }
}
