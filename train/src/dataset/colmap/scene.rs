//! The world of a capture, turned and scaled by what cameras and points say of it.

use std::collections::HashMap;

use glam::DVec3;

use super::model::{Model, Point};
use crate::dataset::capture::World;

/// An image that shows fewer points says nothing of depths, and fewer points nothing of a box.
const FEWEST: usize = 20;
/// The share of depths, and of coordinates, that may be wrong on each side.
const WRONG: f64 = 0.01;
/// The scene's box goes beyond its points by this share of their box on each side: plain walls
/// have few points.
const MARGIN: f64 = 0.5;
/// But not farther from the origin than so many median depths: what is beyond is seen on the
/// faces, and a larger box has coarser cells.
const FARTHEST: f64 = 2.5;
/// A capture's cameras, in the order of its images, and what is known of the scene.
pub(super) struct Scene {
    /// Camera-to-world, row after row.
    pub(super) poses: Vec<[f64; 16]>,
    /// Nearest and farthest depth.
    pub(super) bounds: Option<[f32; 2]>,
    /// The box around its points.
    pub(super) reach: Option<[[f32; 3]; 2]>,
    /// Whether its cameras look one way.
    pub(super) forward_facing: bool,
    /// What was found.
    pub(super) note: String,
}

impl Scene {
    pub(super) fn new(model: &Model) -> Self {
        let mut world = World::default();
        for image in &model.images {
            let half_angle = model.cameras[&image.camera].half_angle;
            world.push(&image.pose.transpose().to_cols_array(), half_angle);
        }
        world.add_points(model.points.iter().map(|point| point.at));
        let depths = depths(model);
        depths.iter().flat_map(|depths| &depths.bounds).for_each(|bounds| world.see(*bounds));
        let forward_facing = depths.is_some() && !world.looks_around();
        if forward_facing {
            world.recentre();
        } else {
            world.stand_up();
            world.scale(1.0 / depths.as_ref().map_or_else(|| world.radius(), |d| d.median));
        }
        let bounds = depths.is_some().then(|| world.bounds());
        let reach = bounds.filter(|_| !forward_facing).and_then(|_| around(world.points()));
        let note = match bounds {
            None => {
                "too few 3-D points: the scene's place follows from the cameras alone".to_owned()
            }
            Some([near, far]) => format!(
                "{} 3-D points in at least 3 images, at depths from {near:.3} to {far:.3}, say \
                 where the scene is; the world is turned and scaled by that",
                model.points.len()
            ),
        };
        Self { poses: world.poses().collect(), bounds, reach, forward_facing, note }
    }
}

/// Depths of points in images.
struct Depths {
    /// From where to where each image that shows enough points sees something.
    bounds: Vec<[f64; 2]>,
    /// Of the images' medians.
    median: f64,
}

/// `None` where no image shows enough points.
fn depths(model: &Model) -> Option<Depths> {
    let views: HashMap<u32, usize> =
        model.images.iter().enumerate().map(|(view, image)| (image.id, view)).collect();
    let mut depths: Vec<Vec<f64>> = vec![Vec::new(); model.images.len()];
    for Point { at, images } in &model.points {
        for &view in images.iter().filter_map(|id| views.get(id)) {
            let pose = &model.images[view].pose;
            let depth = (pose.w_axis.truncate() - *at).dot(pose.z_axis.truncate());
            if depth > 0.0 {
                depths[view].push(depth);
            }
        }
    }
    depths.retain(|depths| depths.len() >= FEWEST);
    depths.iter_mut().for_each(|depths| depths.sort_by(f64::total_cmp));
    let bounds = depths.iter().map(|depths| [at(depths, WRONG), at(depths, 1.0 - WRONG)]).collect();
    let mut medians: Vec<f64> = depths.iter().map(|depths| at(depths, 0.5)).collect();
    medians.sort_by(f64::total_cmp);
    (!medians.is_empty()).then(|| Depths { bounds, median: at(&medians, 0.5) })
}

/// The box around all but the outermost points along each axis, and its margin.
fn around(points: &[DVec3]) -> Option<[[f32; 3]; 2]> {
    if points.len() < FEWEST {
        return None;
    }
    let sides = [0, 1, 2].map(|a| {
        let mut along: Vec<f64> = points.iter().map(|point| point[a]).collect();
        along.sort_by(f64::total_cmp);
        let [low, high] = [at(&along, WRONG), at(&along, 1.0 - WRONG)];
        let margin = MARGIN * (high - low);
        [(low - margin).max(-FARTHEST), (high + margin).min(FARTHEST)]
    });
    let is_box = sides.iter().all(|[low, high]| high - low > 1e-3);
    is_box.then(|| [0, 1].map(|end| sides.map(|side| side[end] as f32)))
}

/// The value of sorted numbers below which such a share of them lies.
fn at(sorted: &[f64], share: f64) -> f64 {
    sorted[(share * (sorted.len() - 1) as f64).round() as usize]
}
