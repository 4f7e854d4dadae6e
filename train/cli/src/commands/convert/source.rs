//! Reads a checkpoint and the files beside it.

use std::path::{Path, PathBuf};

use pocketnerf_formats::import::nerf::Nerf;
use pocketnerf_formats::import::ngp::Ngp;
use pocketnerf_formats::import::volume::{Svox2, TensoRf};
use pocketnerf_formats::import::{Checkpoint, FieldError};
use pocketnerf_train::convert::{
    Conversion, ConvertError, NerfConversion, NgpConversion, Place, Settings, VolumeConversion,
};
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::trainer;

use super::Convert;
use crate::commands::{Common, Failure, read_model};
use crate::convert::{config, nerfstudio};

/// The near plane of normalised device coordinates, the same in all programs.
const NDC_NEAR: f32 = 1.0;

impl Convert {
    /// What a checkpoint holds that is not converted, but learnt from.
    pub(super) fn volume(
        &self,
        checkpoint: &Checkpoint<'_>,
    ) -> Result<Option<VolumeConversion>, Failure> {
        let named = |error: ConvertError| -> Failure {
            format!("{}: {error}", self.input.display()).into()
        };
        if Svox2::recognises(checkpoint) {
            let grid = Svox2::read(checkpoint).map_err(|error| named(error.into()))?;
            let volume = VolumeConversion::svox2(grid, self.scene_scale, self.background);
            return volume.map(Some).map_err(named);
        }
        self.refuse("no grid of svox2", &[("--scene-scale", self.scene_scale.is_some())])?;
        if !TensoRf::recognises(checkpoint) {
            return Ok(None);
        }
        let field = TensoRf::read(checkpoint).map_err(|error| named(error.into()))?;
        let level = self.rendering.vectors.level();
        VolumeConversion::tensorf(field, self.background, level).map(Some).map_err(named)
    }

    /// The field of a checkpoint, and how it is rendered.
    pub(super) fn conversion(
        &self,
        checkpoint: &Checkpoint<'_>,
        better: impl Fn(ConvertError) -> Failure,
        dataset: Option<&Dataset>,
        common: &Common,
    ) -> Result<Conversion, Failure> {
        let named = |error: ConvertError| -> Failure {
            format!("{}: {error}", self.input.display()).into()
        };
        if Ngp::recognises(checkpoint) {
            self.refuse("a hash grid", &self.of_networks())?;
            let mut ngp = Ngp::read(checkpoint).map_err(|error| named(error.into()))?;
            let beside = nerfstudio::complete(&mut ngp, &self.input).map_err(named)?;
            let settings = self.given().or(beside);
            let ngp = NgpConversion::new(ngp, settings, self.aabb, self.rendering.vectors.level());
            return Ok(Conversion::Ngp(ngp.map_err(named)?));
        }
        let mut nerf = self.networks(checkpoint, better)?;
        if self.fine_only {
            nerf.drop_coarse();
        }
        let beside = config::beside(&self.input).map_err(|error| error.to_string())?;
        if let (Some((file, _)), false) = (&beside, common.quiet) {
            eprintln!("note: near, far and the like as in {}", file.display());
        }
        let settings = self.given().or(beside.map(|(_, found)| found).unwrap_or_default());
        let place = |ndc| place(ndc, self.aabb, dataset);
        let nerf = NerfConversion::new(nerf, settings, place, self.rendering.vectors.level());
        Ok(Conversion::Nerf(nerf.map_err(named)?))
    }

    /// Refuses options that would change nothing.
    pub(super) fn refuse(&self, found: &str, given: &[(&str, bool)]) -> Result<(), Failure> {
        match given.iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(format!(
                "{}: this is {found}, for which {option} means nothing; leave it out",
                self.input.display()
            )
            .into()),
            None => Ok(()),
        }
    }

    /// Options of networks of vanilla NeRF, and which are given.
    pub(super) fn of_networks(&self) -> [(&'static str, bool); 7] {
        [
            ("--far", self.far.is_some()),
            ("--samples", self.samples.is_some()),
            ("--ndc", self.ndc),
            ("--along-rays", self.along_rays),
            ("--pixel-origin", self.pixel_origin.is_some()),
            ("--fine", self.fine.is_some()),
            ("--fine-only", self.fine_only),
        ]
    }

    /// The networks of one checkpoint, or of two.
    fn networks(
        &self,
        checkpoint: &Checkpoint<'_>,
        refuse: impl Fn(ConvertError) -> Failure,
    ) -> Result<Nerf, Failure> {
        let refuse = |error: FieldError| refuse(error.into());
        let beside = self.fine.clone().or_else(|| fine_beside(&self.input));
        let Some(path) = beside else { return Nerf::read(checkpoint).map_err(refuse) };
        let bytes = read_model(&path)?;
        let fine = Checkpoint::read(&bytes).map_err(|e| format!("{}: {e}", path.display()))?;
        Nerf::read_both(checkpoint, &fine).map_err(refuse)
    }

    fn given(&self) -> Settings {
        let [coarse, fine] = self.samples.map_or([None; 2], |samples| samples.map(Some));
        Settings {
            near: self.near,
            far: self.far,
            samples: [coarse, fine],
            background: self.background,
            ndc: self.ndc.then_some(true),
            pixel_origin: self.pixel_origin,
            along_rays: self.along_rays.then_some(true),
        }
    }
}

/// Where the scene is.
fn place(
    ndc: bool,
    aabb: Option<[[f32; 3]; 2]>,
    dataset: Option<&Dataset>,
) -> Result<Option<Place>, ConvertError> {
    if !ndc {
        return Ok(aabb.map(Place::Box));
    }
    let dataset = dataset.ok_or(ConvertError::NoCameras(""))?;
    let ndc = trainer::ndc_of(&dataset.views, NDC_NEAR);
    let ndc =
        ndc.ok_or(ConvertError::NoCameras(": the cameras of this one do not look forwards"))?;
    Ok(Some(Place::Ndc(ndc)))
}

/// bmild/nerf writes `model_fine_200000.npy` beside `model_200000.npy`.
fn fine_beside(coarse: &Path) -> Option<PathBuf> {
    let number = coarse.file_name()?.to_str()?.strip_prefix("model_")?;
    let is_coarse = number.ends_with(".npy") && !number.starts_with("fine_");
    let fine = coarse.with_file_name(format!("model_fine_{number}"));
    (is_coarse && fine.is_file()).then_some(fine)
}
