//! The options of `pocketnerf train`, and what they ask for.

use std::fmt::Debug;
use std::path::PathBuf;

use pocketnerf_core::space::Ndc;
use pocketnerf_formats::Precision;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::field::{EncodingConfig, FieldConfig};
use pocketnerf_train::trainer::checkpoint::Problem;
use pocketnerf_train::trainer::{
    Checkpoint, CheckpointError, Length, MAX_BATCH_RAYS, TrainConfig, ndc_of,
};

use super::nerf::NerfOptions;
use crate::commands::{Failure, Reading, parse_color};

/// Seconds of a run where neither time nor steps are given.
const SECONDS: f64 = 120.0;

/// Learn a model from a dataset.
///
/// Ctrl-C finishes the step, saves a checkpoint beside the model (scene.pnerf:
/// scene.ckpt.pnerf), says how to go on and ends with status 130; a second
/// Ctrl-C ends at once.
#[derive(Debug, clap::Args)]
pub(in crate::commands) struct Train {
    /// Dataset folder: images with transforms_train.json (Blender), transforms.json
    /// (instant-ngp, nerfstudio) or poses_bounds.npy (LLFF); `builtin`: the built-in scene.
    pub(super) data: PathBuf,
    /// Model file to write.
    #[arg(long, value_name = "FILE")]
    pub(super) out: PathBuf,
    /// Wall time from program start to the written file; 120 unless told.
    #[arg(long, value_name = "S", conflicts_with = "steps")]
    seconds: Option<f64>,
    /// Train for so many steps instead: repeatable to the bit.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    /// Go on with an interrupted run, on the dataset it began with, to the end
    /// that it was given. Options are those of the checkpoint: give none that
    /// say something else.
    #[arg(long, value_name = "FILE")]
    pub(super) resume: Option<PathBuf>,
    /// Seconds between checkpoints, which are written beside the model
    /// (scene.pnerf: scene.ckpt.pnerf), the last at the end; none unless told.
    #[arg(long, value_name = "S")]
    pub(super) save_every: Option<f64>,
    /// What is trained: hash-grid unless told.
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// What the model is to be good at.
    #[arg(long, value_enum, default_value_t, conflicts_with = "resume")]
    profile: Profile,
    /// Where random numbers begin; 0 unless told.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Rays a step; as many as keep the steps even unless told, 4096 with --method nerf.
    #[arg(long, value_name = "N")]
    batch_rays: Option<usize>,
    /// Train on images so many times smaller; 1 unless told.
    #[arg(long, value_name = "K")]
    downscale_factor: Option<u32>,
    #[command(flatten)]
    pub(super) reading: Reading,
    /// Box of the scene, X0,Y0,Z0,X1,Y1,Z1; the dataset's own unless told,
    /// or found from cameras, silhouettes and a small field.
    #[arg(long, value_name = "BOX", value_parser = crate::commands::parse_box, allow_hyphen_values = true)]
    aabb: Option<[[f32; 3]; 2]>,
    /// Where the scene lies: in a box, or, where all cameras look along -z, in
    /// normalised device coordinates, which reach to infinity; ndc for forward-facing
    /// LLFF captures and box for all else unless told.
    #[arg(long, value_enum, value_name = "KIND")]
    space: Option<SpaceKind>,
    /// Nothing is seen nearer to a camera than this, scene units; 0 unless told. With
    /// --space ndc: nothing nearer to the plane z = 0; 1 unless told.
    #[arg(long, value_name = "N")]
    near: Option<f32>,
    /// Nothing is seen farther than this; everything in the box unless told.
    #[arg(long, value_name = "N")]
    far: Option<f32>,
    /// Learn against one background: white, black or R,G,B. Images with alpha
    /// are trained on all at once, what random ones give on average, unless told; on white
    /// with --sampling hierarchical.
    #[arg(long, value_name = "COLOR", value_parser = parse_color)]
    background: Option<[f32; 3]>,
    /// How the model file holds tables: i8, f16 or f32 (networks: f16 or f32);
    /// i8 unless told, which costs about 0.01 dB.
    #[arg(long, value_name = "TYPE", default_value = "i8", hide_default_value = true,
        value_parser = crate::commands::parse_precision)]
    pub(super) precision: Precision,
    /// Base-two logarithm of the most entries of a grid level.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=24))]
    log2_hashmap_size: Option<u32>,
    /// Levels of the grid; 9 unless told, or 8 with --profile fast. The coarsest and the
    /// finest stay as coarse and as fine.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=16))]
    n_levels: Option<u32>,
    /// Width of the hidden layers behind the grid: 8, 16, 32, 64 or 128.
    #[arg(long, value_name = "N", value_parser = parse_width)]
    hidden_width: Option<u32>,
    /// Learn from so many views, spread evenly over the dataset; from all unless told.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) views: Option<u32>,
    /// Without view dependence: a point has the same colour from everywhere.
    #[arg(long)]
    no_view_dependence: bool,
    #[command(flatten)]
    nerf: NerfOptions,
}

/// What is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Method {
    /// A multiresolution hash grid and small networks: minutes
    HashGrid,
    /// The paper's deep network, which is asked for a thousand times the work
    Nerf,
}

/// Where a scene lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum SpaceKind {
    /// Within a box
    Box,
    /// In front of cameras that look the same way, however far
    Ndc,
}

/// What a model is to be good at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum Profile {
    /// As much detail as the time allows
    #[default]
    Fine,
    /// Pictures in half the time, at about 1 dB less
    Fast,
}

fn parse_width(text: &str) -> Result<u32, String> {
    let width = text.parse().ok().filter(|width| [8, 16, 32, 64, 128].contains(width));
    width.ok_or_else(|| "expected 8, 16, 32, 64 or 128".to_owned())
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
        let (near, far) = (self.near.unwrap_or(0.0), self.far.unwrap_or(f32::MAX));
        if !(near >= 0.0 && near < far && far.is_finite()) {
            let far = self.far.map_or_else(String::new, |far| format!(" --far {far}"));
            return Err(
                format!("--near {near}{far}: expected 0 or more, and far beyond near").into()
            );
        }
        let nerf = self.method == Some(Method::Nerf);
        let shape = self.method.map(|_| "--method").or_else(|| self.nerf.given());
        let shape = shape.or(self.no_view_dependence.then_some("--no-view-dependence"));
        if let (Some(option), Some(_)) = (shape, &self.resume) {
            return Err(format!("{option}: the checkpoint knows; leave it out").into());
        }
        if let (Some(option), false) = (self.nerf.given(), nerf) {
            return Err(format!("{option}: give --method nerf too").into());
        }
        if nerf && self.profile == Profile::Fast {
            return Err("--profile fast: for --method hash-grid alone".into());
        }
        let of_grids = [
            ("--log2-hashmap-size", self.log2_hashmap_size),
            ("--n-levels", self.n_levels),
            ("--hidden-width", self.hidden_width),
        ];
        if let (true, Some((option, _))) = (nerf, of_grids.iter().find(|(_, n)| n.is_some())) {
            return Err(format!("{option}: for --method hash-grid alone").into());
        }
        self.nerf.check()?;
        match self.batch_rays {
            Some(n) if !(1..=MAX_BATCH_RAYS).contains(&n) => {
                Err(format!("--batch-rays {n}: expected 1 to {MAX_BATCH_RAYS}").into())
            }
            _ => Ok(()),
        }
    }

    /// The settings of a new run on this dataset.
    pub(super) fn config(&self, dataset: &Dataset) -> Result<TrainConfig, Failure> {
        let has_alpha = dataset.has_alpha;
        let mut config = match self.method {
            Some(Method::Nerf) => self.nerf.config(has_alpha),
            _ => TrainConfig::hash_grid().for_length(self.length()),
        };
        if self.no_view_dependence {
            config.field.sh_degree = 1;
            if let EncodingConfig::Nerf(nerf) = &mut config.field.encoding {
                nerf.directions = None;
            }
        }
        if self.profile == Profile::Fast {
            config = config.for_speed();
        }
        config.seed = self.seed.unwrap_or(config.seed);
        config.aabb = self.aabb;
        config.ndc = self.ndc(dataset)?;
        if config.ndc.is_none() {
            config.near = self.near.unwrap_or(config.near);
            config.far = self.far;
        }
        config.batch_rays = self.batch_rays.or(config.batch_rays);
        // The paper's pictures with alpha lie on white.
        let white = (config.paper.is_some() && has_alpha).then_some([1.0; 3]);
        config.backdrop = self.background.or(white);
        if let EncodingConfig::HashGrid(grid) = &mut config.field.encoding {
            grid.log2_hashmap_size = self.log2_hashmap_size.unwrap_or(grid.log2_hashmap_size);
            if let Some(n) = self.n_levels {
                let steps = (grid.n_levels - 1) as f32 / (n - 1) as f32;
                grid.per_level_scale = grid.per_level_scale.powf(steps);
                grid.n_levels = n;
            }
            if let Some(width) = self.hidden_width {
                let FieldConfig { density_hidden, color_hidden, .. } = &mut config.field;
                density_hidden
                    .iter_mut()
                    .chain(color_hidden)
                    .for_each(|layer| *layer = width as usize);
            }
        }
        Ok(config)
    }

    /// The coordinates of a forward-facing capture, for those that are and for whoever
    /// asks for them; a box that is given is one.
    fn ndc(&self, dataset: &Dataset) -> Result<Option<Ndc>, Failure> {
        let near = self.near.unwrap_or(1.0);
        let limits = [("--aabb", self.aabb.is_some()), ("--far", self.far.is_some())];
        let limit = limits.into_iter().find(|(_, given)| *given);
        match (self.space, limit) {
            (Some(SpaceKind::Ndc), None) => {}
            (Some(SpaceKind::Ndc), Some((option, _))) => {
                return Err(format!(
                    "{option}: expected none with --space ndc, which holds all that the cameras see"
                )
                .into());
            }
            (None, None) if dataset.forward_facing => return Ok(ndc_of(&dataset.views, near)),
            _ => return Ok(None),
        }
        let ndc = ndc_of(&dataset.views, near).map(Some);
        ndc.ok_or_else(|| {
            format!(
                "{}: --space ndc: a camera sees what does not lie beyond the plane z = -{near}, \
                 expected all to look along -z; give --space box",
                dataset.source
            )
            .into()
        })
    }

    /// The length of a new run.
    pub(in crate::commands) fn length(&self) -> Length {
        let seconds = Length::Seconds(self.seconds.unwrap_or(SECONDS));
        self.steps.map_or(seconds, Length::Steps)
    }

    /// How many times smaller the images of a new run are.
    pub(super) fn downscale_factor(&self) -> u32 {
        self.downscale_factor.unwrap_or(1)
    }

    /// Refuses options that say something else than a checkpoint.
    pub(super) fn check_against(&self, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
        let config = checkpoint.config();
        let (seconds, steps) = match checkpoint.length() {
            Length::Seconds(seconds) => (Some(seconds), None),
            Length::Steps(steps) => (None, Some(steps)),
        };
        let (log2_hashmap_size, n_levels) = match config.field.encoding {
            EncodingConfig::HashGrid(grid) => (Some(grid.log2_hashmap_size), Some(grid.n_levels)),
            EncodingConfig::Nerf(_) => (None, None),
        };
        let FieldConfig { density_hidden, color_hidden, .. } = &config.field;
        let mut widths = density_hidden.iter().chain(color_hidden);
        let width = widths.next().filter(|&width| widths.all(|other| other == width));
        let hidden_width = width.map(|&width| width as u32);
        let (space, near) = match config.ndc {
            None => (SpaceKind::Box, config.near),
            Some(ndc) => (SpaceKind::Ndc, ndc.near),
        };
        let downscale_factor = Some(checkpoint.trained_on().downscale_factor);
        same("--seconds", self.seconds, seconds)
            .and_then(|()| same("--steps", self.steps, steps))
            .and_then(|()| same("--seed", self.seed, Some(config.seed)))
            .and_then(|()| same("--batch-rays", self.batch_rays, config.batch_rays))
            .and_then(|()| same("--downscale-factor", self.downscale_factor, downscale_factor))
            .and_then(|()| same("--aabb", self.aabb, config.aabb))
            .and_then(|()| same("--space", self.space, Some(space)))
            .and_then(|()| same("--near", self.near, Some(near)))
            .and_then(|()| same("--far", self.far, config.far))
            .and_then(|()| same("--background", self.background, config.backdrop))
            .and_then(|()| same("--log2-hashmap-size", self.log2_hashmap_size, log2_hashmap_size))
            .and_then(|()| same("--n-levels", self.n_levels, n_levels))
            .and_then(|()| same("--hidden-width", self.hidden_width, hidden_width))
            .map_err(|problem| problem.of(checkpoint.file()))
    }
}

/// Refuses an option that was given and says something else than what is stored.
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
