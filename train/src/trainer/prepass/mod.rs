//! What is found out before there is a [`Trainer`](super::Trainer): the box of the scene and
//! the cells that may hold something.

mod box_fit;
pub(crate) mod coarse_field;
mod deadline;
mod exposure;
pub(crate) mod scene_box;
pub(crate) mod scene_contracted;
pub(crate) mod scene_ndc;
mod teachers;
pub(crate) mod visual_hull;

use pocketnerf_core::{Camera, Error, SimdLevel, Space};

use super::occupancy::cells::MOST_CELLS;
use super::pixels::rays::{Backdrop, RaySource};
use super::{TrainConfig, all_cells};
use crate::cameras::{distances, nearest_to_axes};
use crate::dataset::Dataset;
pub use box_fit::BoxFit;
pub use deadline::{Deadline, PrepassError};
use scene_box::find_box;
pub use teachers::{MOST_TEACHERS, TeacherError};
use visual_hull::VisualHull;

/// Share of the least distance of a camera from what all look at: the nearest depth, where nothing
/// else tells it.
const NEAREST: f32 = 0.5;

/// What a run begins with.
#[derive(Debug)]
pub struct Prepared {
    /// The training views.
    pub source: RaySource,
    /// Coordinates of the scene.
    pub space: Space,
    /// Cells that may hold something.
    pub candidates: Vec<u32>,
    /// The silhouettes, where there are some.
    pub(crate) hull: Option<VisualHull>,
    /// Settings, with the box that was found.
    pub config: TrainConfig,
}

/// Finds the space of a scene and the cells that may hold something, by silhouettes and,
/// where that helps, by training a small field for a second or three.
///
/// # Errors
/// When the configuration does not make a valid field, the SIMD level is not there, or the
/// deadline passes.
pub fn run(
    dataset: Dataset,
    mut config: TrainConfig,
    simd: SimdLevel,
    deadline: Deadline,
) -> Result<Prepared, PrepassError> {
    config.field.kind().validate()?;
    if config.occupancy_resolution > MOST_CELLS {
        return Err(Error::Range("occupancy resolution").into());
    }
    let has_alpha = dataset.has_alpha;
    let backdrop = match (config.backdrop, has_alpha, dataset.background) {
        (Some(color), ..) | (None, false, Some(color)) => Backdrop::Color(color),
        (None, true, _) => Backdrop::Random,
        (None, false, None) => Backdrop::Hidden(config.opaque_backdrop),
    };
    let source = RaySource::new(dataset.views, backdrop);
    if let Some(ndc) = config.ndc {
        // All that the cameras see lies there, and silhouettes hide little of it.
        config.aabb = None;
        return prepared(source, None, Space::Ndc(ndc), config, (simd, deadline));
    }
    if let Some(contracted) = config.contracted {
        config.aabb = None;
        let known = dataset.bounds.filter(|_| dataset.reach.is_some());
        let nearest = nearest(known, has_alpha, source.cameras());
        let source = source.with_nearest(nearest);
        return prepared(source, None, Space::Contracted(contracted), config, (simd, deadline));
    }
    // Silhouettes say more than points do.
    let reach = dataset.reach.filter(|_| !has_alpha);
    config.aabb = config.aabb.or(dataset.aabb).or(reach);
    let nearest = nearest(reach.and(dataset.bounds), has_alpha, source.cameras());
    let source = source.with_nearest(nearest);
    let hull = has_alpha.then(|| VisualHull::before(&source, deadline));
    let (space, source) = match (config.aabb, &hull) {
        (Some([min, max]), _) => (Space::Box { min, max }, source),
        (None, None) => (find_box(source.cameras(), None), source),
        (None, Some(hull)) => {
            let around = find_box(source.cameras(), Some(hull));
            deadline.check()?;
            coarse_field::tighten(around, source, hull, &config, (simd, deadline))?
        }
    };
    // A checkpoint holds it: a resumed run does not look for it again.
    config.aabb = space.scene_box();
    prepared(source, hull, space, config, (simd, deadline))
}

/// The nearest depth of a scene: that of its points, `known`. Where photographs are opaque and nothing
/// is known of points, it is taken to be half of the least distance of a camera from what all of
/// them look at.
fn nearest(known: Option<[f32; 2]>, has_alpha: bool, cameras: &[Camera]) -> Option<f32> {
    if known.is_some() || has_alpha {
        return known.map(|[near, _]| near);
    }
    let poses: Vec<[f32; 16]> = cameras.iter().map(|camera| camera.camera_to_world).collect();
    // Axes that are parallel meet nowhere.
    nearest_to_axes(&poses)?;
    let (_, distances) = distances(cameras);
    Some(NEAREST * distances.into_iter().fold(f32::INFINITY, f32::min))
}

/// In this space.
fn prepared(
    source: RaySource,
    hull: Option<VisualHull>,
    space: Space,
    config: TrainConfig,
    (simd, deadline): (SimdLevel, Deadline),
) -> Result<Prepared, PrepassError> {
    config.sampling(&space)?;
    // Where poses are wrong, silhouettes cut parts of the scene off.
    let hull = hull.filter(|_| !config.refine_poses);
    let kind = config.field.kind();
    let prepared = carved(source, hull.as_ref(), space, config.clone());
    deadline.check()?;
    if !(kind.is_costly() || kind.is_sparse()) || kind.hierarchical_training().is_some() {
        return Ok(Prepared { hull, ..prepared });
    }
    let (candidates, source) = coarse_field::cells(prepared, hull.as_ref(), (simd, deadline))?;
    Ok(Prepared { source, space, candidates, hull, config })
}

/// With the cells that the silhouettes allow.
fn carved(
    source: RaySource,
    hull: Option<&VisualHull>,
    space: Space,
    config: TrainConfig,
) -> Prepared {
    let resolution = config.occupancy_resolution;
    let candidates = match hull {
        Some(hull) => hull.cells(&space, resolution),
        None => all_cells(&space, resolution),
    };
    Prepared { source, space, candidates, hull: None, config }
}
