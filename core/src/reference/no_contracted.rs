//! Builds without contracted space.

use crate::Ray;
use crate::space::Contracted;

/// No value exists.
pub(super) enum Pieces {}

impl Pieces {
    pub(super) fn new(space: &Contracted, _: &Ray) -> Option<Self> {
        match *space {}
    }

    pub(super) fn point(&self, _: f32) -> Option<[f32; 3]> {
        match *self {}
    }

    pub(super) fn length(&self) -> f32 {
        match *self {}
    }

    pub(super) fn depth(&self, _: f64) -> f64 {
        match *self {}
    }
}

pub(super) fn point(space: &Contracted, _: [f32; 3]) -> [f32; 3] {
    match *space {}
}
