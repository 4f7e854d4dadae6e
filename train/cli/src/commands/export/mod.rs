//! `pocketnerf export`.

mod cameras;
mod files;

use std::error::Error;
use std::path::PathBuf;

use cameras::up;
use files::Format;
use pocketnerf_core::Camera;
use pocketnerf_formats::{ModelFile, World};
use pocketnerf_train::output;
use pocketnerf_train::surface::{self, NoSurface, Surface, Texture, compare, file, surface};
use serde_json::{Value, json};

use super::parse::{parse_box, parse_direction};
use super::progress::Progress;
use super::rendering::Vectors;
use super::train::parse_metres;
use super::{Common, Failure, Reading, memory, open_to_render, read_model};

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
    /// Simplify to at most so many triangles: first where the surface moves least
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..))]
    triangles: Option<u32>,
    /// Put colours into an image instead of vertices, SIZE texels a side: a power of two from 256 to
    /// 8192 [default: 2048]
    ///
    /// A .glb file has it inside; beside scene.obj, scene.mtl and scene.png are written. Colours are
    /// then as fine as the image is, however few triangles there are.
    #[arg(long, value_name = "SIZE", num_args = 0..=1, require_equals = true,
        default_missing_value = "2048", value_parser = parse_size, requires = "mesh")]
    texture: Option<u32>,
    /// Close the surface: what no camera sees counts as solid
    #[arg(long)]
    watertight: bool,
    /// Up direction in the dataset's coordinates: x, y, z, -x, -y, -z or three numbers [default: as
    /// the model says, or the axis nearest to the up direction of the cameras]
    ///
    /// It becomes +y in a .glb file, where that is up.
    #[arg(long, value_name = "AXIS", value_parser = parse_direction, allow_hyphen_values = true)]
    up: Option<[f32; 3]>,
    /// Metres per unit of the dataset's coordinates, for .glb files, which are in metres [default:
    /// as the model says, or 1]
    #[arg(long, value_name = "METRES", value_parser = parse_metres)]
    scale: Option<f32>,
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
        let format = self.check()?;
        let bytes = read_model(&self.model)?;
        let mut table = Vec::new();
        let file = open_to_render(&self.model, &bytes, &mut table)?;
        let (cameras, views) = self.cameras(&file, common)?;
        let mut surface = self.surface(&file, &cameras, common)?;
        let similarity = file.about.scene.similarity();
        // A closed surface ends at the box already, and is to stay closed.
        if let (Some(corners), false) = (self.crop, self.watertight) {
            surface.mesh.crop(corners, &similarity);
        }
        if surface.mesh.triangles.is_empty() {
            return Err(self.refused(&NoSurface::Nothing { cropped: true }));
        }
        let mut warnings = Vec::new();
        if let Some(most) = self.triangles {
            surface.simplify(most as usize);
            warnings.extend(self.too_many(surface.mesh.triangles.len(), most));
        }
        warnings.iter().for_each(|warning| common.warn(warning));
        let texture = self.texture.map(|size| self.bake(&surface, size, common)).transpose()?;
        let mut mesh = surface.mesh;
        mesh.move_to_dataset(&similarity);
        // A part is not compared with the whole.
        let error = if self.crop.is_none() { compare(&mesh, &views) } else { None };
        let known = file.about.world;
        let up = self.up.or(known.up).unwrap_or_else(|| up(&file, &cameras));
        let world = World { up: Some(up), metres: self.scale.or(known.metres) };
        let mut written = Vec::new();
        if let (Some(path), Some(format)) = (&self.mesh, format) {
            written = format.write(path, &mesh, texture.as_ref(), &world)?;
        }
        if let Some(path) = &self.points {
            written.push((path.clone(), file::points(&mesh)));
        }
        for (path, bytes) in &written {
            output::write_atomic(path, bytes)?;
        }
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        if common.json {
            let name = |path: &Option<PathBuf>| path.as_ref().map(|p| p.display().to_string());
            let texture = texture.as_ref().map(|texture| {
                json!({ "size": texture.size, "used": texture.used, "charts": texture.charts })
            });
            let object = json!({
                "model": self.model.display().to_string(),
                "method": file.model.field.kind(),
                "mesh": name(&self.mesh),
                "points": name(&self.points),
                "bytes": written.iter().map(|(_, bytes)| bytes.len()).sum::<usize>(),
                "cameras": cameras.len(),
                "vertices": vertices,
                "triangles": triangles,
                "texture": texture,
                "area": mesh.area(),
                "bounds": mesh.bounds(),
                "up": up,
                "surface_error": error.map_or(Value::Null, |error| json!(error)),
                "seconds": common.started.elapsed().as_secs_f64(),
            });
            common.print_json(object, &warnings);
        } else if !common.quiet {
            for (path, bytes) in &written {
                let megabytes = bytes.len() as f64 / 1e6;
                let what = if Some(path) == self.points.as_ref() {
                    format!("{vertices} points, ")
                } else if Some(path) == self.mesh.as_ref() {
                    format!("{triangles} triangles, {vertices} vertices, ")
                } else {
                    String::new()
                };
                common.say(&format!("{}: {what}{megabytes:.1} MB", path.display()));
            }
            if let Some(texture) = texture {
                common.say(&format!(
                    "texture: {size}x{size}, {charts} charts on {used:.0} % of it",
                    size = texture.size,
                    charts = texture.charts,
                    used = 100.0 * texture.used
                ));
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

    /// Refuses, before any work, what cannot be written; the mesh's format.
    fn check(&self) -> Result<Option<Format>, Failure> {
        let format = self.mesh.as_deref().map(Format::of).transpose()?;
        if let Some(path) = &self.points {
            Format::expect(path, &["ply"])?;
        }
        let mut paths: Vec<PathBuf> = self.mesh.iter().chain(&self.points).cloned().collect();
        if let (Some(path), Some(format), true) = (&self.mesh, format, self.texture.is_some()) {
            if format == Format::Ply {
                return Err(format!(
                    "{}: --texture, but a .ply file has no place for one, expected .glb or .obj",
                    path.display()
                )
                .into());
            }
            let beside = format.beside(path).into_iter().flatten();
            paths.extend(beside.map(|name| path.with_file_name(name)));
        }
        for path in &paths {
            output::check_output(path)?;
        }
        if let (Some(path), true) = (&self.mesh, self.mesh == self.points) {
            return Err(
                format!("{}: --mesh and --points, expected a file each", path.display()).into()
            );
        }
        Ok(format)
    }

    fn surface(
        &self,
        file: &ModelFile<'_>,
        cameras: &[Camera],
        common: &Common,
    ) -> Result<Surface, Failure> {
        let settings = surface::Settings {
            simd: self.vectors.level(),
            resolution: self.resolution,
            crop: self.crop.map(|corners| file.about.scene.box_to_model(corners)),
            watertight: self.watertight,
        };
        let (surface_bytes, texture_bytes) = (
            surface::memory_bytes(cameras, &settings),
            self.texture.map_or(0, surface::texture_bytes),
        );
        let (what, advice) = match self.texture {
            Some(_) => ("a surface with a texture", "give a smaller --texture or --resolution"),
            None => ("a surface", "give a smaller --resolution"),
        };
        memory::check(surface_bytes + texture_bytes, advice, || what.to_owned())?;
        let pictures = surface::pictures(&file.model, cameras);
        let mut progress = Progress::new("pictures", pictures, common);
        surface(&file.model, cameras, &settings, |done| progress.done(done))
            .map_err(|error| self.refused(&error))
    }

    fn bake(&self, surface: &Surface, size: u32, common: &Common) -> Result<Texture, Failure> {
        let mut progress = Progress::new("rows of the texture", size as usize, common);
        surface.texture(size, |done| progress.done(done)).map_err(|error| self.refused(&error))
    }

    fn refused(&self, error: &dyn Error) -> Failure {
        format!("{}: {error}", self.model.display()).into()
    }

    /// What to say of a mesh that still has more triangles than it may.
    fn too_many(&self, triangles: usize, most: u32) -> Option<String> {
        (triangles > most as usize).then(|| {
            format!(
                "{}: the surface has {triangles} triangles, expected at most {most}: fewer would lose \
                 its parts or close its holes; give a smaller --resolution",
                self.model.display()
            )
        })
    }
}

/// The width of a texture.
fn parse_size(text: &str) -> Result<u32, String> {
    let size = text.parse().ok().filter(|size| surface::SIZES.contains(size));
    size.ok_or_else(|| "expected a power of two from 256 to 8192".to_owned())
}
