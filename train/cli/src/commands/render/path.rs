//! Where pictures are taken from.

use std::path::PathBuf;

use pocketnerf_core::camera::Orbit;
use pocketnerf_core::{Camera, Space};
use pocketnerf_formats::About;
use pocketnerf_train::cameras::{self, CameraPath, Circle, Pace, Wanted, tour};

use crate::commands::Failure;

/// Pictures of a video without a path of its own.
const VIDEO_VIEWS: usize = 300;
/// Options that ask for a circle.
const CIRCLE: [&str; 4] = ["center", "radius", "elevation", "arc"];

#[derive(Debug, clap::Args)]
pub(super) struct Path {
    /// Render N views along a path
    ///
    /// Without the options below it stays among the photographs, around what they look at, and ends
    /// where it begins. Where the model does not say where these were taken, and with any of the
    /// options below, it is a circle around the scene.
    #[arg(long, value_name = "N")]
    orbit: Option<usize>,
    /// Centre of the circle, in the dataset's coordinates [default: the scene's]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_numbers::<3>, allow_hyphen_values = true)]
    center: Option<[f32; 3]>,
    /// Distance of the circle's cameras from its centre, in the dataset's units [default: that of
    /// the model's own camera]
    #[arg(long, value_name = "R")]
    radius: Option<f32>,
    /// Angle of the circle's cameras above its centre, degrees, or from where to where they rise:
    /// with an --arc of several turns, a spiral [default: 29]
    #[arg(long, value_name = "DEG|FROM,TO", value_parser = parse_rise, allow_hyphen_values = true)]
    elevation: Option<[f32; 2]>,
    /// Part of the circle, from one angle to another, degrees: 0 lies in x, 90 in y; 0,720 goes
    /// around twice [default: 0,360]
    #[arg(long, value_name = "FROM,TO", value_parser = parse_numbers::<2>, allow_hyphen_values = true)]
    arc: Option<[f32; 2]>,
    /// Begin and end slowly
    #[arg(long, conflicts_with_all = ["pose", "camera_path"])]
    ease: bool,
    /// Camera-to-world pose in the dataset's coordinates, as text or a file: 16 numbers or
    /// 4 rows of 4
    #[arg(long, value_name = "JSON", conflicts_with_all = ["camera_path", "orbit"], conflicts_with_all = CIRCLE)]
    pose: Option<String>,
    /// Camera path: nerfstudio's camera_path.json, instant-ngp's base_cam.json or a transforms.json
    ///
    /// Where a file has keyframes alone, a smooth path goes through them.
    #[arg(long, value_name = "JSON", conflicts_with = "orbit", conflicts_with_all = CIRCLE)]
    camera_path: Option<PathBuf>,
    /// How long a path of keyframes takes [default: as the file says, else 2 from each to the next]
    #[arg(long, value_name = "S", requires = "camera_path")]
    seconds: Option<f64>,
    /// Picture width [default: as the model file says]
    #[arg(long, value_name = "W")]
    width: Option<u32>,
    /// Picture height [default: as the model file says]
    #[arg(long, value_name = "H")]
    height: Option<u32>,
    /// Horizontal field of view, degrees [default: as the model file says]
    #[arg(long, value_name = "DEG")]
    fov: Option<f32>,
}

/// What is known of a scene.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) about: &'a About<'a>,
    pub(super) space: &'a Space,
}

impl Path {
    /// The cameras, in the model's coordinates.
    pub(super) fn cameras(
        &self,
        place: Place<'_>,
        (is_video, fps): (bool, Option<f32>),
    ) -> Result<CameraPath, Failure> {
        if let Some(file_of_path) = &self.camera_path {
            return self.stored(file_of_path, place, fps);
        }
        let cameras = self.found(place, is_video)?;
        Ok(CameraPath { cameras, fps: fps.map(f64::from) })
    }

    /// Those of a file.
    fn stored(
        &self,
        path: &std::path::Path,
        place: Place<'_>,
        fps: Option<f32>,
    ) -> Result<CameraPath, Failure> {
        let given = self.width.zip(self.height).map(|(width, height)| [width, height]);
        if let Some(size) = given {
            check_size(size)?;
        }
        let fps = fps.map(f64::from);
        let wanted = Wanted { size: given, fps, seconds: self.seconds };
        let mut path = cameras::camera_path(path, wanted)?;
        for camera in &mut path.cameras {
            *camera = place.about.scene.camera_to_model(camera);
        }
        Ok(path)
    }

    /// Those of a circle, of a path among the photographs, or one.
    fn found(&self, place: Place<'_>, is_video: bool) -> Result<Vec<Camera>, Failure> {
        let own = place.about.camera.map(|c| c.camera());
        let scene = &place.about.scene;
        let size = [
            self.width.or(own.map(|c| c.width)).unwrap_or(400),
            self.height.or(own.map(|c| c.height)).unwrap_or(400),
        ];
        check_size(size)?;
        let fov_x = self.fov.map_or_else(|| Circle::fov_x(own.as_ref()), f32::to_radians);
        if !(0.01..3.1).contains(&fov_x) {
            return Err(format!(
                "field of view {:.1}: expected 1 to 177 degrees",
                fov_x.to_degrees()
            )
            .into());
        }
        let camera = |pose| Camera::from_fov_x(size[0], size[1], fov_x, pose);
        if let Some(pose) = &self.pose {
            return Ok(vec![scene.camera_to_model(&camera(cameras::pose(pose)?))]);
        }
        let views = self.orbit.or(is_video.then_some(VIDEO_VIEWS));
        let is_circle = self.center.is_some()
            || self.radius.is_some()
            || self.elevation.is_some()
            || self.arc.is_some();
        if let (None, false, Some(own)) = (views, is_circle, own) {
            return Ok(vec![camera(own.camera_to_world)]);
        }
        let views = views.unwrap_or(1);
        if !(1..=10_000).contains(&views) {
            return Err(format!("--orbit {views}: expected 1 to 10000 views").into());
        }
        let photographs = place.about.photographs.filter(|_| !is_circle);
        let poses: Vec<[f32; 16]> = photographs.iter().flat_map(|all| all.poses()).collect();
        let pace = if self.ease { Pace::Eased } else { Pace::Even };
        if let Some(path) = tour(&poses, views, pace) {
            return Ok(path.into_iter().map(camera).collect());
        }
        let mut circle = Circle::around(place.space, own.as_ref(), views, fov_x);
        circle.first = self.fitted(circle.first, place)?;
        let arc = self.arc.map(|arc| arc.map(f32::to_radians));
        let rise = self.elevation.map(|[_, to]| to.to_radians());
        Ok(Circle { size, arc, rise, pace, ..circle }.cameras())
    }

    /// The circle that is asked for.
    fn fitted(&self, first: Orbit, place: Place<'_>) -> Result<Orbit, Failure> {
        let scene = &place.about.scene;
        let [axis, up] = match *place.space {
            Space::Ndc(_) => [first.axis, first.up],
            _ => [scene.to_model_direction(place.about.world.up()); 2],
        };
        let radius = self.radius.map_or(first.radius, |radius| radius / scene.scale);
        if let (Some(asked), false) = (self.radius, radius > 0.0 && radius < 1e6) {
            return Err(format!("--radius {asked}: expected more than 0, and less than 1e6").into());
        }
        let elevations = self.elevation.map(|both| both.map(f32::to_radians));
        let [elevation, _] = elevations.unwrap_or([first.elevation; 2]);
        if let Some(steep) = elevations.iter().flatten().find(|e| !(-1.57..1.57).contains(*e)) {
            return Err(format!(
                "--elevation {}: expected less than 90 degrees up or down",
                steep.to_degrees()
            )
            .into());
        }
        let target = self.center.map_or(first.target, |center| scene.to_model(center));
        Ok(Orbit { target, radius, elevation, axis, up, ..first })
    }
}

fn check_size(size: [u32; 2]) -> Result<(), Failure> {
    if size.iter().any(|side| !(1..=16_384).contains(side)) {
        return Err(format!("picture size {size:?}: expected 1 to 16384 a side").into());
    }
    Ok(())
}

/// A number, or two with a comma between them: from and to.
fn parse_rise(text: &str) -> Result<[f32; 2], String> {
    match text.contains(',') {
        true => parse_numbers(text),
        false => parse_numbers::<1>(text)
            .map(|[both]| [both; 2])
            .map_err(|_| "expected a number, or two: FROM,TO".to_owned()),
    }
}

/// So many numbers, between commas.
fn parse_numbers<const N: usize>(text: &str) -> Result<[f32; N], String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    let numbers = numbers.ok().and_then(|numbers| <[f32; N]>::try_from(numbers).ok());
    let numbers = numbers.filter(|numbers| numbers.iter().all(|x| x.is_finite()));
    numbers.ok_or_else(|| format!("expected {N} numbers with commas between them"))
}
