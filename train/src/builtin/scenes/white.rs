//! The plainest scene: a matt white ball before the white background.

use crate::builtin::contents::Body;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::DVec3;

pub(super) fn bodies() -> Vec<Body> {
    vec![Body::new(Shape::sphere(DVec3::ZERO, 0.9), Surface::White)]
}
