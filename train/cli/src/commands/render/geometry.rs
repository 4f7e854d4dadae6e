//! Numbers beside the pictures: how far each pixel sees, and where what it sees faces.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use pocketnerf_core::{Camera, Error};
use pocketnerf_formats::ModelFile;
use pocketnerf_train::output::OutputError;
use pocketnerf_train::picture::{self, Picture, Settings, exr_file, image_file};

/// A kind of file.
#[derive(Clone, Copy, Debug, Hash, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Eight or sixteen bits
    Png,
    /// 32-bit floats
    Exr,
}

#[derive(Clone, Copy, Debug, Hash, Args)]
pub(super) struct Geometry {
    /// Also write depth in the dataset's units, as 16-bit PNG or as EXR
    ///
    /// Depth is the mean distance from the camera to what a pixel sees. `view.depth.png`, beside
    /// `view.png`, has it in thousandths of a unit, up to 65.535, and 0 where nothing is;
    /// `view.depth.exr` as it is, in channel Y, and infinity where nothing is.
    #[arg(
        long, value_enum, value_name = "png|exr", num_args = 0..=1, require_equals = true,
        default_missing_value = "png", hide_possible_values = true
    )]
    pub(super) depth: Option<Format>,
    /// Also write normals in the dataset's axes, as 8-bit PNG or as EXR
    ///
    /// A normal is a unit vector towards the camera, of the surface that holds back half of the light
    /// through a pixel's centre. `view.normals.png`, beside `view.png`, has 255 (n + 1) / 2 of x, y and
    /// z as red, green and blue, and black where there is no surface; `view.normals.exr` has n itself
    /// in channels R, G and B, and zeros. Normals are computed on the CPU.
    #[arg(
        long, value_enum, value_name = "png|exr", num_args = 0..=1, require_equals = true,
        default_missing_value = "png", hide_possible_values = true, conflicts_with = "deadline_ms"
    )]
    pub(super) normals: Option<Format>,
}

/// The numbers of a picture's pixels, in the dataset's units and axes; none where they are not
/// asked for.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    pub(super) depth: Vec<f32>,
    pub(super) normals: Vec<[f32; 3]>,
}

impl Geometry {
    /// The first option that asks for something.
    pub(super) fn option(&self) -> Option<&'static str> {
        let depth = self.depth.map(|_| "--depth");
        depth.or(self.normals.map(|_| "--normals"))
    }

    /// Bytes a pixel, in memory and in the file that becomes of them.
    pub(super) fn bytes_a_pixel(&self) -> u64 {
        let depth = if self.depth.is_some() { 16 } else { 0 };
        let normals = if self.normals.is_some() { 48 } else { 0 };
        depth + normals
    }

    /// The numbers of what `camera`, in the model's coordinates, has taken.
    pub(super) fn of(
        &self,
        (file, settings): (&ModelFile<'_>, &Settings),
        camera: &Camera,
        picture: &Picture,
    ) -> Result<Numbers, Error> {
        let scene = &file.about.scene;
        let mut numbers = Numbers::default();
        if self.depth.is_some() {
            numbers.depth = picture.depth.iter().map(|depth| scene.scale * depth).collect();
        }
        if self.normals.is_some() {
            numbers.normals.resize(picture.rgba.len() / 4, [0.0; 3]);
            picture::normals(&file.model, camera, settings, &mut numbers.normals)?;
            for normal in &mut numbers.normals {
                *normal = scene.similarity().to_dataset_direction(*normal);
            }
        }
        Ok(numbers)
    }

    /// The files beside a picture.
    pub(super) fn files(&self, picture: &Path) -> impl Iterator<Item = PathBuf> {
        let depth = self.depth.map(|format| beside(picture, "depth", format));
        let normals = self.normals.map(|format| beside(picture, "normals", format));
        depth.into_iter().chain(normals)
    }

    /// Writes them.
    pub(super) fn write(
        &self,
        picture: &Path,
        camera: &Camera,
        numbers: &Numbers,
    ) -> Result<(), OutputError> {
        let Camera { width, height, .. } = *camera;
        let Numbers { depth, normals } = numbers;
        if let Some(format) = self.depth {
            let path = beside(picture, "depth", format);
            match format {
                Format::Png => {
                    let per_step = image_file::DEPTH_UNITS_PER_STEP;
                    image_file::write_depth(&path, width, height, depth, per_step)?;
                }
                Format::Exr => exr_file::write_depth(&path, width, height, depth)?,
            }
        }
        if let Some(format) = self.normals {
            let path = beside(picture, "normals", format);
            match format {
                Format::Png => image_file::write_normals(&path, width, height, normals)?,
                Format::Exr => exr_file::write_normals(&path, width, height, normals)?,
            }
        }
        Ok(())
    }
}

/// `view.png` → `view.depth.exr`.
fn beside(picture: &Path, what: &str, format: Format) -> PathBuf {
    let extension = match format {
        Format::Png => "png",
        Format::Exr => "exr",
    };
    picture.with_extension(format!("{what}.{extension}"))
}
