//! Where the scene lies: options of `pocketnerf train`.

use std::fmt;

use clap::ValueEnum;
use pocketnerf_core::space::{Contracted, Ndc};
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::trainer::prepass::MOST_TEACHERS;
use pocketnerf_train::trainer::{Length, TrainConfig, contracted_of, ndc_of};

use crate::commands::Failure;
use crate::commands::parse::{parse_box, parse_color};

/// The coordinates of a scene.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum SpaceKind {
    /// A box
    Box,
    /// Normalised device coordinates: all that forward-facing cameras see, to infinity
    Ndc,
    /// Contracted space: all that cameras see around them, to infinity
    Contracted,
}

/// The coordinates of a new run: a box, unless one of these is there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coordinates {
    ndc: Option<Ndc>,
    contracted: Option<Contracted>,
}

impl Coordinates {
    pub(super) const fn is_box(&self) -> bool {
        self.ndc.is_none() && self.contracted.is_none()
    }
}

/// Nothing is nearer to a camera than this share of the nearest depth that a dataset knows: fog
/// before a camera would explain its photograph as well as the scene does.
const NEAREST: f32 = 0.5;

/// Whether photographs are evened out.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Exposure {
    /// Where their exposure or white balance differs by more than chance
    Auto,
    /// They are taken as they are
    Off,
}

/// Whether thin fog stays.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Fog {
    /// It is removed in the second half of the run, unless training views become worse, as with smoke
    /// or glass
    Clear,
    /// It stays
    Keep,
}

// Refusals show values as the command line has them.
impl fmt::Debug for Fog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&word(self))
    }
}

impl fmt::Debug for SpaceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&word(self))
    }
}

impl fmt::Debug for Exposure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&word(self))
    }
}

/// A value's word on the command line.
fn word(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |word| word.get_name().to_owned())
}

#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Scene")]
pub(super) struct SceneOptions {
    /// Coordinates of the scene [default: ndc for forward-facing captures of LLFF and COLMAP;
    /// box for images with alpha and where the dataset or --aabb says a box; else contracted]
    #[arg(long, value_enum, value_name = "KIND")]
    pub(super) space: Option<SpaceKind>,
    /// Box of the scene, X0,Y0,Z0,X1,Y1,Z1 in the dataset's coordinates [default: the dataset's own,
    /// or found from points, cameras, silhouettes and a small field]
    #[arg(long, value_name = "BOX", value_parser = parse_box, allow_hyphen_values = true)]
    pub(super) aabb: Option<[[f32; 3]; 2]>,
    /// Ignore what is nearer to a camera, scene units [default: half the nearest depth where the
    /// dataset says it, else 0]; with --space ndc what is nearer to the plane z = 0 [default: 1]
    #[arg(long, value_name = "N")]
    pub(super) near: Option<f32>,
    /// Ignore what is farther from a camera, scene units [default: no limit]
    #[arg(long, value_name = "N")]
    pub(super) far: Option<f32>,
    /// Train against one background: white, black or R,G,B [default: the expectation over
    /// random ones for images with alpha, white with --sampling hierarchical; none for opaque images]
    ///
    /// Opaque images show the scene in every pixel, and the model becomes opaque; with a background,
    /// what has its colour may be left out. Those whose edges all show one plain colour are cut out, and
    /// need no --background; another colour than theirs keeps it as a part of the scene.
    #[arg(long, value_name = "COLOR", value_parser = parse_color)]
    pub(super) background: Option<[f32; 3]>,
    /// Even out photographs that are brighter or of another colour than the others [default: auto]
    #[arg(long, value_enum, value_name = "KIND")]
    pub(super) exposure: Option<Exposure>,
    /// Correct the pose of each photograph while training, for cameras that are known to a degree
    /// or so
    ///
    /// What all corrections have in common is taken out, so that other views keep their poses. No
    /// views are held out. `--json` has the corrected cameras.
    #[arg(long, conflicts_with = "target_psnr")]
    pub(super) refine_poses: bool,
    /// Train N fields first, and learn from the mean of what they show between the photographs, too
    /// [default: 2 for less than 32 forward-facing photographs and 8 minutes or 20,000 steps, else 0]
    ///
    /// What one field gets wrong between few photographs is half chance. Each takes as many steps as
    /// the run, or an equal share of 60 % of its time, on the CPU. For photographs without alpha and
    /// of one exposure. Where a GPU trains, none by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=i64::from(MOST_TEACHERS)))]
    pub(super) teachers: Option<u32>,
    /// Whether thin fog in front of surfaces is removed [default: clear for photographs without alpha,
    /// unless they are taken around a scene and come with 3-D points; else keep]
    ///
    /// For hash grids and planes. Rooms gain about 1 dB without fog, and more frames are rendered per
    /// second. What only a few photographs see may be lost. `fog_cleared` in JSON says what was done.
    #[arg(long, value_enum, value_name = "KIND")]
    pub(super) fog: Option<Fog>,
    /// Hold surfaces to be smooth: walls and bodies of one colour, which photographs leave rough
    ///
    /// WEIGHT is that of a bend beside the error of a colour: 0 for none, 0.005 if it is left out.
    /// Without this option it is 0.02 where a hash grid or planes learn from photographs without
    /// alpha, and 0 elsewhere; it is 0, too, where these are taken around a scene and come with 3-D
    /// points, as COLMAP's do. Fine relief that photographs hardly show is smoothed too.
    #[arg(
        long, value_name = "WEIGHT", num_args = 0..=1, require_equals = true,
        default_missing_value = "0.005"
    )]
    pub(super) smooth_surfaces: Option<f32>,
}

impl SceneOptions {
    /// Refuses numbers that make no sense.
    pub(super) fn check(&self) -> Result<(), Failure> {
        let (near, far) = (self.near.unwrap_or(0.0), self.far.unwrap_or(f32::MAX));
        if !(near >= 0.0 && near < far && far.is_finite()) {
            let far = self.far.map_or_else(String::new, |far| format!(" --far {far}"));
            return Err(
                format!("--near {near}{far}: expected 0 or more, and far beyond near").into()
            );
        }
        let weight = self.smooth_surfaces.unwrap_or(0.0);
        if !(weight.is_finite() && weight >= 0.0) {
            return Err(format!("--smooth-surfaces={weight}: expected 0 or more").into());
        }
        Ok(())
    }

    /// An option that was given and means nothing to baselines.
    pub(super) fn given_for_fields(&self) -> Option<&'static str> {
        let given = [
            ("--space", self.space.is_some()),
            ("--exposure", self.exposure.is_some()),
            ("--refine-poses", self.refine_poses),
            ("--teachers", self.teachers.is_some()),
            ("--fog", self.fog.is_some()),
            ("--smooth-surfaces", self.smooth_surfaces.is_some()),
        ];
        given.iter().find(|(_, given)| *given).map(|(option, _)| *option)
    }

    /// The coordinates of a new run.
    pub(super) fn space(&self, dataset: &Dataset) -> Result<Coordinates, Failure> {
        Ok(Coordinates { ndc: self.ndc(dataset)?, contracted: self.contracted(dataset)? })
    }

    /// Adds these settings to those of a new run.
    pub(super) fn apply(
        &self,
        mut config: TrainConfig,
        dataset: &Dataset,
        space: Coordinates,
        length: Length,
    ) -> Result<TrainConfig, Failure> {
        config.aabb = self.aabb.map(|corners| dataset.box_as_read(corners));
        config.ndc = space.ndc;
        if let Some(contracted) = space.contracted {
            config = config.contracted(contracted, length);
        }
        if config.ndc.is_none() {
            let known = dataset.bounds.map(|[near, _]| NEAREST * near);
            let known = known.filter(|near| self.far.is_none_or(|far| *near < far));
            config.near = self.near.or(known).unwrap_or(config.near);
            config.near /= config.contracted.map_or(1.0, |contracted| contracted.radius);
            config.far = self.far;
        }
        // Images with alpha are on white in the original NeRF.
        let one = config.hierarchical_training().is_some() && dataset.has_alpha;
        let usual = one.then(|| dataset.background.unwrap_or([1.0; 3]));
        config.backdrop = self.background.or(usual);
        if self.refine_poses && config.field.kind().n_levels() == 0 {
            return Err("--refine-poses: for --method hash-grid and planes alone".into());
        }
        config.refine_poses = self.refine_poses;
        if self.fog == Some(Fog::Clear) && config.field.kind().n_levels() == 0 {
            return Err("--fog clear: expected --method hash-grid or planes".into());
        }
        config.clear_fog = self.fog.map_or(config.clear_fog, |fog| fog == Fog::Clear);
        if self.smooth_surfaces.is_some() && config.hierarchical_training().is_some() {
            return Err("--smooth-surfaces: expected no --sampling hierarchical".into());
        }
        config.smooth_surfaces = self.smooth_surfaces.unwrap_or(config.smooth_surfaces);
        Ok(config)
    }

    /// The coordinates of a scene without an end, by default or if asked for. A box that is
    /// given, silhouettes and cameras that look forwards rule them out.
    fn contracted(&self, dataset: &Dataset) -> Result<Option<Contracted>, Failure> {
        let cameras: Vec<_> = dataset.views.iter().map(|view| view.camera).collect();
        match self.space {
            Some(SpaceKind::Contracted) => {}
            None if !(dataset.has_alpha
                || dataset.forward_facing
                || dataset.aabb.is_some()
                || self.limit().is_some()) =>
            {
                return Ok(contracted_of(&cameras, dataset.reach));
            }
            _ => return Ok(None),
        }
        if let Some((option, _)) = self.limit() {
            return Err(format!(
                "{option}: expected none with --space contracted, which holds all that the \
                 cameras see"
            )
            .into());
        }
        let contracted = contracted_of(&cameras, dataset.reach).map(Some);
        contracted.ok_or_else(|| {
            format!(
                "{}: --space contracted: all cameras are in one place, expected them around \
                 what they look at; give --space box",
                dataset.source
            )
            .into()
        })
    }

    /// What limits the scene.
    fn limit(&self) -> Option<(&'static str, bool)> {
        let limits = [("--aabb", self.aabb.is_some()), ("--far", self.far.is_some())];
        limits.into_iter().find(|(_, given)| *given)
    }

    /// The coordinates of a forward-facing capture, by default or if asked for. A box that is
    /// given rules them out.
    fn ndc(&self, dataset: &Dataset) -> Result<Option<Ndc>, Failure> {
        let near = self.near.unwrap_or(1.0);
        match (self.space, self.limit()) {
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
}
