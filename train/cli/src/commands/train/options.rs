//! The options of `pocketnerf train`.

use std::fmt::Debug;
use std::path::PathBuf;

use pocketnerf_formats::Precision;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::trainer::checkpoint::Problem;
use pocketnerf_train::trainer::{Checkpoint, CheckpointError, Length, MAX_BATCH_RAYS, TrainConfig};

use super::kinds::{Images, Method};
use super::model::ModelOptions;
use super::scene::{Exposure, Fog, SceneOptions, SpaceKind};
use super::watch::WatchOptions;
use super::world::WorldOptions;
use crate::commands::device::TrainingDevice;
use crate::commands::parse::{parse_precision, parse_seconds};
use crate::commands::rendering::Vectors;
use crate::commands::{Failure, Reading};

/// Seconds of a run if neither time nor steps are given.
pub(in crate::commands) const SECONDS: f64 = 120.0;

#[derive(Debug, clap::Args)]
pub(in crate::commands) struct Train {
    /// Dataset folder, or `builtin` or `builtin:NAME`: a built-in scene
    ///
    /// Reads Blender (transforms_train.json), instant-ngp and nerfstudio (transforms.json),
    /// COLMAP (sparse/0 and the like), LLFF (poses_bounds.npy), DeepVoxels, and what Metashape,
    /// RealityCapture, Polycam, Record3D and 3d Scanner App export.
    ///
    /// NAME: still-life (as without a name), wires, glossy, glass, foliage, fog, white, room or
    /// village.
    pub(super) data: PathBuf,
    /// Model file to write
    #[arg(long, value_name = "FILE")]
    pub(super) out: PathBuf,
    /// Wall time from program start to the written file: 90, 90s, 2m, 1h [default: 2m]
    #[arg(long, value_name = "TIME", conflicts_with = "steps", value_parser = parse_seconds)]
    pub(super) seconds: Option<f64>,
    /// Train for N steps instead: bit-for-bit reproducible
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) steps: Option<u32>,
    /// Format of tables in the model file: i8 (networks: f16), f16 or f32
    #[arg(long, value_name = "TYPE", default_value = "i8", value_parser = parse_precision)]
    pub(super) precision: Precision,
    /// Resume from a checkpoint; its settings are reused
    ///
    /// Takes the same dataset and continues to the end that the run was started with. Options
    /// that contradict the checkpoint are refused.
    #[arg(long, value_name = "FILE")]
    pub(super) resume: Option<PathBuf>,
    /// Write a checkpoint beside the model every TIME (scene.pnerf: scene.ckpt.pnerf), and
    /// at the end [default: never]
    #[arg(long, value_name = "TIME", value_parser = parse_seconds)]
    pub(super) save_every: Option<f64>,
    #[command(flatten)]
    pub(super) watch: WatchOptions,
    /// Random seed [default: 0]
    #[arg(long, value_name = "N")]
    pub(super) seed: Option<u64>,
    /// Rays per step [default: adapted to keep steps even; 4096 with --method nerf or derf]
    #[arg(long, value_name = "N")]
    pub(super) batch_rays: Option<usize>,
    /// Downscale images by this factor [default: 1]
    #[arg(long, value_name = "K", help_heading = "Dataset")]
    pub(super) downscale_factor: Option<u32>,
    /// Train on at most N views, evenly spread [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..),
        help_heading = "Dataset")]
    pub(super) views: Option<u32>,
    #[command(flatten)]
    pub(super) reading: Reading,
    #[command(flatten)]
    pub(super) scene: SceneOptions,
    #[command(flatten)]
    pub(super) world: WorldOptions,
    #[command(flatten)]
    pub(super) model: ModelOptions,
    #[command(flatten)]
    pub(super) vectors: Vectors,
    #[command(flatten)]
    pub(super) device: TrainingDevice,
}

impl Train {
    /// Refuses numbers that make no sense.
    pub(in crate::commands) fn check(&self) -> Result<(), Failure> {
        let times = [("--seconds", self.seconds), ("--save-every", self.save_every)];
        for (option, given) in times {
            if let Some(given) = given.filter(|s| !(*s > 0.0 && *s < 1e7)) {
                return Err(format!("{option} {given}: expected a positive number").into());
            }
        }
        self.scene.check()?;
        self.model.check(self.resume.is_some())?;
        match self.batch_rays {
            Some(n) if !(1..=MAX_BATCH_RAYS).contains(&n) => {
                Err(format!("--batch-rays {n}: expected 1 to {MAX_BATCH_RAYS}").into())
            }
            _ => Ok(()),
        }
    }

    /// The settings of a new run on this dataset.
    pub(super) fn config(&self, dataset: &Dataset) -> Result<TrainConfig, Failure> {
        let space = self.scene.space(dataset)?;
        let method = self.method(space.is_box() && dataset.has_alpha);
        let (length, _) = self.lengths(self.n_teachers(dataset));
        let mut config = self.model.config(method, Images::of(dataset), length);
        config.seed = self.seed.unwrap_or(config.seed);
        config.batch_rays = self.batch_rays.or(config.batch_rays);
        // Where points say how near the scene comes, samples near the cameras learn nearly as much
        // as others, and what is fog there becomes a wall.
        let is_far = dataset.reach.is_none() || dataset.forward_facing;
        if !dataset.has_alpha && is_far && config.field.kind().n_levels() > 0 {
            config.smooth_surfaces = TrainConfig::SMOOTH_PLACES;
            config.clear_fog = true;
        }
        self.scene.apply(config, dataset, space, length)
    }

    /// The length of a new run.
    pub(in crate::commands) fn length(&self) -> Length {
        let seconds = Length::Seconds(self.seconds.unwrap_or(SECONDS));
        self.steps.map_or(seconds, Length::Steps)
    }

    /// What a new run on this dataset trains on the CPU, where no option says it.
    pub(in crate::commands) fn usual_method(dataset: &Dataset) -> Result<Method, Failure> {
        let in_box = SceneOptions::default().space(dataset)?.is_box();
        Ok(Method::usual(in_box && dataset.has_alpha))
    }

    /// What a new run trains: of an object, in a box and in photographs with alpha, or of
    /// another scene. GPUs train hash grids.
    pub(in crate::commands) fn method(&self, is_object: bool) -> Method {
        self.model.method(is_object && !self.device.is_gpu())
    }

    /// The factor by which the images of a new run are downscaled.
    pub(super) fn downscale_factor(&self) -> u32 {
        self.downscale_factor.unwrap_or(1)
    }

    /// Refuses options that contradict a checkpoint.
    pub(super) fn check_against(&self, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
        let config = checkpoint.config();
        let (seconds, steps) = match checkpoint.length() {
            Length::Seconds(seconds) => (Some(seconds), None),
            Length::Steps(steps) => (None, Some(steps)),
        };
        let (space, near) = match (config.ndc, config.contracted) {
            (Some(ndc), _) => (SpaceKind::Ndc, ndc.near),
            (_, Some(contracted)) => {
                let given = self.scene.near.filter(|near| near / contracted.radius == config.near);
                (SpaceKind::Contracted, given.unwrap_or(config.near * contracted.radius))
            }
            _ => (SpaceKind::Box, config.near),
        };
        let downscale_factor = Some(checkpoint.trained_on().downscale_factor);
        let kept = self.scene.exposure.filter(|exposure| *exposure == Exposure::Off);
        let refined = self.scene.refine_poses.then_some(true);
        let teachers = checkpoint.n_teachers() as u32;
        let smooth = Some(config.smooth_surfaces);
        let fog = if config.clear_fog { Fog::Clear } else { Fog::Keep };
        let aabb = self.scene.aabb.map(|corners| checkpoint.scene().box_to_model(corners));
        let exposure = if checkpoint.is_evened_out() { Exposure::Auto } else { Exposure::Off };
        let shape = || {
            let mut options = self.model.against(config).into_iter();
            options.try_for_each(|(option, given, stored)| same(option, given, stored))
        };
        same("--seconds", self.seconds, seconds)
            .and_then(|()| same("--steps", self.steps, steps))
            .and_then(|()| same("--seed", self.seed, Some(config.seed)))
            .and_then(|()| same("--batch-rays", self.batch_rays, config.batch_rays))
            .and_then(|()| same("--downscale-factor", self.downscale_factor, downscale_factor))
            .and_then(|()| same("--aabb", aabb, config.aabb))
            .and_then(|()| same("--space", self.scene.space, Some(space)))
            .and_then(|()| same("--near", self.scene.near, Some(near)))
            .and_then(|()| same("--far", self.scene.far, config.far))
            .and_then(|()| same("--background", self.scene.background, config.backdrop))
            .and_then(|()| same("--exposure", kept, Some(exposure)))
            .and_then(|()| same("--refine-poses", refined, Some(config.refine_poses)))
            .and_then(|()| same("--teachers", self.scene.teachers, Some(teachers)))
            .and_then(|()| same("--fog", self.scene.fog, Some(fog)))
            .and_then(|()| same("--smooth-surfaces", self.scene.smooth_surfaces, smooth))
            .and_then(|()| shape())
            .map_err(|problem| problem.of(checkpoint.file()))
    }
}

/// Refuses an option whose given value is not the stored one.
fn same<T: Debug + PartialEq>(
    option: &'static str,
    given: Option<T>,
    stored: Option<T>,
) -> Result<(), Problem> {
    match given {
        Some(given) if Some(&given) != stored.as_ref() => Err(Problem::Option {
            option,
            given: format!("{given:?}"),
            stored: stored.map(|value| format!("{value:?}")),
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use clap::Parser;
    use pocketnerf_train::builtin;
    use pocketnerf_train::dataset::Split;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        train: Train,
    }

    /// As these options of the command line have it.
    pub(in crate::commands::train) fn train(options: &[&str]) -> Train {
        let line = ["train", "data", "--out", "m.pnerf"].iter().chain(options);
        Line::parse_from(line).train
    }

    #[test]
    fn places_are_smooth_unless_points_say_how_near_they_come() {
        let weight = |options: &[&str], change: &dyn Fn(&mut Dataset)| {
            let mut dataset = builtin::dataset(Split::Train, 8);
            dataset.has_alpha = false;
            change(&mut dataset);
            train(options).config(&dataset).unwrap().smooth_surfaces
        };
        let reach = Some([[-1.0; 3], [1.0; 3]]);
        assert_eq!(weight(&[], &|_| {}), TrainConfig::SMOOTH_PLACES);
        assert_eq!(weight(&[], &|dataset| dataset.has_alpha = true), 0.0);
        assert_eq!(weight(&[], &|dataset| dataset.reach = reach), 0.0);
        assert_eq!(weight(&["--method", "nerf"], &|_| {}), 0.0);
        assert_eq!(weight(&["--smooth-surfaces=0.1"], &|dataset| dataset.reach = reach), 0.1);
        assert_eq!(weight(&["--smooth-surfaces=0"], &|_| {}), 0.0);
    }

    #[test]
    fn fog_is_cleared_where_surfaces_are_smooth_by_default() {
        let clears = |options: &[&str], change: &dyn Fn(&mut Dataset)| {
            let mut dataset = builtin::dataset(Split::Train, 8);
            dataset.has_alpha = false;
            change(&mut dataset);
            train(options).config(&dataset).unwrap().clear_fog
        };
        let reach = Some([[-1.0; 3], [1.0; 3]]);
        assert!(clears(&[], &|_| {}) && clears(&["--smooth-surfaces=0"], &|_| {}));
        assert!(!clears(&[], &|dataset| dataset.has_alpha = true));
        assert!(!clears(&[], &|dataset| dataset.reach = reach));
        assert!(!clears(&["--method", "nerf"], &|_| {}));
        assert!(!clears(&["--fog", "keep"], &|_| {}));
        assert!(clears(&["--fog", "clear"], &|dataset| dataset.reach = reach));
        let dataset = builtin::dataset(Split::Train, 8);
        let refused = train(&["--fog", "clear", "--method", "nerf"]).config(&dataset);
        let expected = "--fog clear: expected --method hash-grid or planes";
        assert_eq!(refused.unwrap_err().to_string(), expected);
    }
}
