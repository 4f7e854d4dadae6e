//! The world of a capture, turned and scaled by what cameras and points say of it.

use std::collections::HashMap;

use glam::DVec3;

use super::model::{Model, Point};
use crate::dataset::Own;
use crate::dataset::capture::{FEWEST, WRONG, World, at, reach};

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
    /// COLMAP's own coordinates.
    pub(super) own: Option<Own>,
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
        let from_sides = world.looks_around() || world.looks_from_sides();
        let forward_facing = depths.is_some() && !from_sides;
        if forward_facing {
            world.recentre();
        } else {
            world.stand_up();
            world.scale(1.0 / depths.as_ref().map_or_else(|| world.radius(), |d| d.median));
        }
        let bounds = depths.is_some().then(|| world.bounds());
        let points_reach = |_| reach(world.points(), DVec3::ZERO, FARTHEST);
        let reach = bounds.filter(|_| !forward_facing).and_then(points_reach);
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
        let (poses, own) = (world.poses().collect(), world.own());
        Self { poses, bounds, reach, forward_facing, own, note }
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
