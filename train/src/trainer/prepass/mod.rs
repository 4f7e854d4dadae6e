//! What is found out before the first step: the box of the scene and the cells that may
//! hold something.

pub(crate) mod coarse_field;
pub(crate) mod scene_box;
pub(crate) mod scene_ndc;
pub(crate) mod visual_hull;
