//! `pocketnerf export`.

use std::path::{Path, PathBuf};

use glam::Vec3;
use pocketnerf_core::Camera;
use pocketnerf_formats::{ModelFile, Photographs};
use pocketnerf_train::cameras::sphere;
use pocketnerf_train::dataset::{Split, View, thin};
use pocketnerf_train::output;
use pocketnerf_train::surface::{self, Mesh, compare, file, surface};
use serde_json::{Value, json};

use super::eval::shift;
use super::parse::parse_box;
use super::progress::Progress;
use super::rendering::Vectors;
use super::{Common, Failure, Reading, memory, open_to_render, read_model};

/// More cameras tell little more.
const CAMERAS: usize = 100;

#[derive(Debug, clap::Args)]
pub(super) struct Export {
    /// Model file
    model: PathBuf,
    /// Triangles with normals and colours: .glb, .ply or .obj
    #[arg(long, value_name = "FILE", required_unless_present = "points")]
    mesh: Option<PathBuf>,
    /// Points with normals and colours: .ply
    #[arg(long, value_name = "FILE")]
    points: Option<PathBuf>,
    /// Voxels along the longest side of what is seen; a vertex is about as far from the next
    #[arg(long, value_name = "N", default_value_t = 256,
        value_parser = clap::value_parser!(u32).range(16..=2048))]
    resolution: u32,
    /// Only what lies in this box, X0,Y0,Z0,X1,Y1,Z1 in the dataset's coordinates
    #[arg(long, value_name = "BOX", value_parser = parse_box, allow_hyphen_values = true)]
    crop: Option<[[f32; 3]; 2]>,
    /// Close the surface: what no camera sees counts as solid
    #[arg(long)]
    watertight: bool,
    /// Axis of the dataset that points up: x, y, z, -x, -y or -z [default: the axis nearest to what
    /// is up in the cameras]
    ///
    /// It becomes +y in a .glb file, where that is up.
    #[arg(long, value_name = "AXIS", value_parser = parse_axis, allow_hyphen_values = true)]
    up: Option<[f32; 3]>,
    /// Look from this dataset's training cameras [default: from those photographs whose cameras the
    /// model stores; where it stores none, from a sphere around it]
    ///
    /// Where it knows true depths, as built-in scenes do, the whole surface is also compared with
    /// these.
    #[arg(long, value_name = "DATA", help_heading = "Dataset")]
    data: Option<PathBuf>,
    /// Downscale its images by this factor
    #[arg(long, value_name = "K", default_value_t = 1, help_heading = "Dataset")]
    downscale_factor: u32,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    vectors: Vectors,
}

impl Export {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let write = self.mesh.as_deref().map(Format::of).transpose()?;
        if let Some(path) = &self.points {
            Format::expect(path, &["ply"])?;
        }
        for path in self.mesh.iter().chain(&self.points) {
            output::check_output(path)?;
        }
        if let (Some(path), true) = (&self.mesh, self.mesh == self.points) {
            return Err(
                format!("{}: --mesh and --points, expected a file each", path.display()).into()
            );
        }
        let bytes = read_model(&self.model)?;
        let mut table = Vec::new();
        let file = open_to_render(&self.model, &bytes, &mut table)?;
        let (cameras, views) = self.cameras(&file, common)?;
        let crop = self.crop.map(|corners| in_model(&file, corners));
        let simd = self.vectors.level();
        let settings = surface::Settings {
            simd,
            resolution: self.resolution,
            crop,
            watertight: self.watertight,
        };
        let needed = surface::memory_bytes(&cameras, &settings);
        memory::check(needed, "give a smaller --resolution", || "a surface".to_owned())?;
        let refused = |error: &surface::NoSurface| -> Failure {
            format!("{}: {error}", self.model.display()).into()
        };
        let mut progress =
            Progress::new("pictures", surface::pictures(&file.model, &cameras), common);
        let mut mesh = surface(&file.model, &cameras, &settings, |done| progress.done(done))
            .map_err(|error| refused(&error))?;
        drop(progress);
        let similarity = file.about.scene.similarity();
        mesh.move_to_dataset(&similarity);
        // A closed surface ends at the box already, and is to stay closed.
        if let (Some(corners), false) = (self.crop, self.watertight) {
            mesh.crop(corners);
        }
        if mesh.triangles.is_empty() {
            return Err(refused(&surface::NoSurface::Nothing { cropped: true }));
        }
        // A part is not compared with the whole.
        let error = if self.crop.is_none() { compare(&mesh, &views) } else { None };
        let up = self.up.unwrap_or_else(|| up(&file, &cameras));
        let mut written = Vec::new();
        if let (Some(path), Some(format)) = (&self.mesh, write) {
            written.push((path, format.write(&mesh, up)));
        }
        if let Some(path) = &self.points {
            written.push((path, file::points(&mesh)));
        }
        for (path, bytes) in &written {
            output::write_atomic(path, bytes)?;
        }
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        if common.json {
            let name = |path: &Option<PathBuf>| path.as_ref().map(|p| p.display().to_string());
            let object = json!({
                "model": self.model.display().to_string(),
                "method": file.model.field.kind(),
                "mesh": name(&self.mesh),
                "points": name(&self.points),
                "bytes": written.iter().map(|(_, bytes)| bytes.len()).sum::<usize>(),
                "cameras": cameras.len(),
                "vertices": vertices,
                "triangles": triangles,
                "area": mesh.area(),
                "bounds": mesh.bounds(),
                "up": up,
                "surface_error": error.map_or(Value::Null, |error| json!(error)),
                "seconds": common.started.elapsed().as_secs_f64(),
            });
            common.print_json(object, &[]);
        } else if !common.quiet {
            for (path, bytes) in &written {
                let megabytes = bytes.len() as f64 / 1e6;
                let what = match Some(*path) == self.points.as_ref() {
                    true => format!("{vertices} points"),
                    false => format!("{triangles} triangles, {vertices} vertices"),
                };
                common.say(&format!("{}: {what}, {megabytes:.1} MB", path.display()));
            }
            if let Some(error) = error {
                common.say(&format!(
                    "Chamfer distance to the truth: {:.3} % of its diagonal; normals {:.1} degrees",
                    error.chamfer_percent, error.normal_degrees
                ));
            }
        }
        Ok(())
    }

    /// Cameras to look from, in the model's coordinates, and the dataset's views, in its own.
    fn cameras(
        &self,
        file: &ModelFile<'_>,
        common: &Common,
    ) -> Result<(Vec<Camera>, Vec<View>), Failure> {
        let own = file.about.camera.map(|camera| camera.camera());
        let shifted = |mut camera: Camera| {
            shift(&mut camera, file.about.pixel_origin, 1);
            camera
        };
        let Some(data) = &self.data else {
            if let Some(photographs) = file.about.photographs.filter(|all| !all.is_empty()) {
                return Ok((taken(&photographs, own.as_ref()).map(shifted).collect(), Vec::new()));
            }
            if file.model.space.scene_box().is_none() {
                return Err(format!(
                    "{}: its scene has no box to look at from outside, and it does not say where \
                     photographs were taken; give --data, the dataset whose cameras look at it",
                    self.model.display()
                )
                .into());
            }
            let side = (2 * self.resolution).min(1024);
            return Ok((sphere(&file.model.space, own.as_ref(), CAMERAS, side), Vec::new()));
        };
        let mut views = self.reading.load(data, Split::Train, self.downscale_factor, common)?.views;
        thin(&mut views, CAMERAS);
        let camera = |view: &View| shifted(file.about.scene.camera_to_model(&view.camera));
        Ok((views.iter().map(camera).collect(), views))
    }
}

/// The cameras of photographs, with pictures as large as those of the model's own camera.
fn taken(photographs: &Photographs<'_>, own: Option<&Camera>) -> impl Iterator<Item = Camera> {
    let [width, height] = own.map_or([400; 2], |camera| [camera.width, camera.height]);
    let fov_x = 2.0 * (0.5 / photographs.focal).atan();
    photographs.poses().map(move |pose| Camera::from_fov_x(width, height, fov_x, pose))
}

/// The box in the model's coordinates around this one of the dataset's.
fn in_model(file: &ModelFile<'_>, [low, high]: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
    let corner = |i: usize| {
        let corner = [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
        Vec3::from(file.about.scene.to_model(corner))
    };
    let first = corner(0);
    let (low, high) =
        (1..8).map(corner).fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    [low.to_array(), high.to_array()]
}

/// The dataset's axis that is nearest to what is up in the model's own camera, or in all cameras.
fn up(file: &ModelFile<'_>, cameras: &[Camera]) -> [f32; 3] {
    let own = file.about.camera.map(|camera| camera.camera());
    let mean = own.as_slice().iter().chain(cameras).map(|camera| {
        let pose = file.about.scene.camera_to_dataset(camera).camera_to_world;
        Vec3::new(pose[1], pose[5], pose[9])
    });
    let mean: Vec3 = mean.sum();
    let axis = mean.abs().max_position();
    let mut up = [0.0; 3];
    up[axis] = if mean[axis] < 0.0 { -1.0 } else { 1.0 };
    up
}

/// A unit vector along an axis.
fn parse_axis(text: &str) -> Result<[f32; 3], String> {
    let (sign, name) = match text.strip_prefix('-') {
        Some(name) => (-1.0, name),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let axis = ["x", "y", "z"].iter().position(|axis| *axis == name);
    let axis = axis.ok_or_else(|| "expected x, y, z, -x, -y or -z".to_owned())?;
    let mut up = [0.0; 3];
    up[axis] = sign;
    Ok(up)
}

/// A format of meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Glb,
    Ply,
    Obj,
}

impl Format {
    /// By the file's name.
    fn of(path: &Path) -> Result<Self, Failure> {
        Ok(match Self::expect(path, &["glb", "ply", "obj"])?.as_str() {
            "glb" => Self::Glb,
            "ply" => Self::Ply,
            _ => Self::Obj,
        })
    }

    /// The ending of the file's name, if it is one of these.
    fn expect(path: &Path, known: &[&str]) -> Result<String, Failure> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let ending = ending.unwrap_or_default();
        if known.contains(&ending.as_str()) {
            return Ok(ending);
        }
        let known: Vec<String> = known.iter().map(|ending| format!(".{ending}")).collect();
        let expected = known.join(", ");
        Err(format!("{}: the file's name ends in {ending:?}, expected {expected}", path.display())
            .into())
    }

    fn write(self, mesh: &Mesh, up: [f32; 3]) -> Vec<u8> {
        match self {
            Self::Glb => file::glb(mesh, up),
            Self::Ply => file::ply(mesh),
            Self::Obj => file::obj(mesh),
        }
    }
}
