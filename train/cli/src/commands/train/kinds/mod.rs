//! Kinds of field: what `--method` names, and the options of each.

mod derf;
mod nerf;
mod planes;
mod plenoxels;

use pocketnerf_formats::Precision;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::field::FieldConfig;
use pocketnerf_train::trainer::{Length, TrainConfig};

use crate::commands::Failure;
use derf::DerfOptions;
use nerf::NerfOptions;
use planes::PlanesOptions;
use plenoxels::PlenoxelOptions;

/// What is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(in crate::commands) enum Method {
    /// A multiresolution hash grid and small networks: minutes
    HashGrid,
    /// Planes and lines (TensoRF) and small networks: minutes
    Planes,
    /// A sparse grid of voxels with spherical harmonics, without networks (Plenoxels)
    Plenoxels,
    /// The original NeRF MLP (about 1,000 times slower)
    Nerf,
    /// Small NeRF MLPs for parts of the scene (DeRF)
    Derf,
    /// A multiplane image for each photograph, the nearest blended (LLFF): a baseline
    Llff,
    /// Networks that march along rays (scene representation networks): a baseline
    Srn,
    /// A cube of colours and opacities that a network makes (neural volumes): a baseline
    NeuralVolumes,
}

impl Method {
    /// Its name on a command line.
    pub(in crate::commands) const fn name(self) -> &'static str {
        match self {
            Self::HashGrid => "hash-grid",
            Self::Nerf => "nerf",
            Self::Plenoxels => "plenoxels",
            Self::Planes => "planes",
            Self::Derf => "derf",
            Self::Llff => "llff",
            Self::Srn => "srn",
            Self::NeuralVolumes => "neural-volumes",
        }
    }

    /// The baseline of this name, which is no field.
    pub(in crate::commands) const fn baseline(self) -> Option<pocketnerf_baselines::Method> {
        match self {
            Self::Llff => Some(pocketnerf_baselines::Method::Llff),
            Self::Srn => Some(pocketnerf_baselines::Method::Srn),
            Self::NeuralVolumes => Some(pocketnerf_baselines::Method::NeuralVolumes),
            _ => None,
        }
    }

    /// Options of `pocketnerf train` for a model to compare with others.
    pub(in crate::commands) fn options(self) -> Vec<&'static str> {
        let batch: &[&str] = match self {
            Self::Nerf | Self::Derf => &["--batch-rays", "1024"],
            _ => &[],
        };
        [&["--method", self.name()], batch].concat()
    }

    /// How values of its tables are stored; networks alone have none of eight bits.
    pub(in crate::commands) const fn precision(self) -> Precision {
        match self {
            Self::Nerf | Self::Derf => Precision::F16,
            _ => Precision::I8,
        }
    }

    /// Options of `pocketnerf train` for a model that many runs can be made of.
    pub(in crate::commands) const fn small(self) -> &'static [&'static str] {
        match self {
            Self::HashGrid => &["--method", "hash-grid"],
            Self::Nerf => {
                &["--method", "nerf", "--depth", "4", "--width", "64", "--batch-rays", "1024"]
            }
            Self::Plenoxels => &["--method", "plenoxels", "--voxels", "128"],
            Self::Planes => &["--method", "planes"],
            Self::Derf => {
                &["--method", "derf", "--heads", "4", "--width", "32", "--batch-rays", "1024"]
            }
            Self::Llff => &["--method", "llff"],
            Self::Srn => &["--method", "srn"],
            Self::NeuralVolumes => &["--method", "neural-volumes"],
        }
    }

    /// What is trained of a scene that planes suit, or of another one, where nothing else is asked
    /// for.
    pub(super) const fn usual(suits_planes: bool) -> Self {
        match suits_planes {
            true => Self::Planes,
            false => Self::HashGrid,
        }
    }

    /// Options of `pocketnerf train` that give each of its tables 2^`log2` entries, where it has
    /// tables.
    pub(in crate::commands) const fn entries(self) -> Option<fn(log2: f64) -> [String; 2]> {
        match self {
            Self::HashGrid => Some(|log2| ["--log2-hashmap-size".to_owned(), log2.to_string()]),
            Self::Planes => {
                Some(|log2| ["--plane-resolution".to_owned(), (log2 / 2.0).exp2().to_string()])
            }
            _ => None,
        }
    }
}

/// What of images the shape of a field depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Images {
    pub(super) has_alpha: bool,
    /// Pixels across.
    pub(super) pixels: f32,
}

impl Images {
    /// Some, where nothing depends on them.
    pub(super) const ANY: Self = Self { has_alpha: true, pixels: 100.0 };

    pub(super) fn of(dataset: &Dataset) -> Self {
        Self { has_alpha: dataset.has_alpha, pixels: dataset.pixels_across() }
    }
}

/// The options of all kinds but the hash grid, in the order of [`Method`], as `--help` has them.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct KindOptions {
    #[command(flatten)]
    planes: PlanesOptions,
    #[command(flatten)]
    plenoxels: PlenoxelOptions,
    #[command(flatten)]
    nerf: NerfOptions,
    #[command(flatten)]
    derf: DerfOptions,
}

impl KindOptions {
    /// An option that was given of each kind, if any.
    fn given_of_each(&self) -> [(Method, Option<&'static str>); 4] {
        [
            (Method::Planes, self.planes.given()),
            (Method::Plenoxels, self.plenoxels.given()),
            (Method::Nerf, self.nerf.given()),
            (Method::Derf, self.derf.given()),
        ]
    }

    /// What to say of options that are not for photographs of so many pixels across.
    pub(super) fn doubt(&self, across: f32) -> Option<String> {
        self.planes.doubt(across)
    }

    /// Whether an option of planes was given, which asks for them.
    pub(super) fn ask_for_planes(&self) -> bool {
        self.planes.given().is_some()
    }

    /// An option that was given, to refuse it where a run goes on.
    pub(super) fn given(&self) -> Option<&'static str> {
        self.given_of_each().into_iter().find_map(|(_, option)| option)
    }

    /// Refuses options of other kinds, and those that make no sense.
    pub(super) fn check(&self, method: Method) -> Result<(), Failure> {
        for (of, option) in self.given_of_each() {
            // Heads are vanilla NeRFs.
            let other = method != of && (method, of) != (Method::Derf, Method::Nerf);
            if let (Some(option), true) = (option, other) {
                return Err(format!("{option}: give --method {} too", of.name()).into());
            }
        }
        if let (Some(option), Method::Derf) = (self.nerf.given_for_whole(), method) {
            return Err(format!("{option}: for --method nerf alone").into());
        }
        self.nerf.check()
    }

    /// The settings of a new run of so much time on such images.
    pub(super) fn config(&self, method: Method, images: Images, length: Length) -> TrainConfig {
        match method {
            // Baselines are no fields, and have no such settings.
            Method::HashGrid | Method::Llff | Method::Srn | Method::NeuralVolumes => {
                TrainConfig::hash_grid().for_length(length)
            }
            Method::Nerf => self.nerf.config(images.has_alpha),
            Method::Derf => self.derf.config(&self.nerf),
            Method::Planes => self.planes.config(images.pixels, length),
            Method::Plenoxels => self.plenoxels.config(),
        }
    }
}

/// A point has the same colour from everywhere.
pub(super) fn omit_view_dependence(field: &mut FieldConfig) {
    match field {
        FieldConfig::HashGrid(field) => field.sh_degree = 1,
        FieldConfig::Planes(field) => field.sh_degree = 1,
        FieldConfig::Nerf(nerf) => nerf.directions = None,
        FieldConfig::Derf(derf) => derf.head.directions = None,
        FieldConfig::Plenoxels(voxels) => voxels.sh_degree = 1,
    }
}
