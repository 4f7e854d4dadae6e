//! Builds without contracted space: there is none, and nothing to link.

use crate::space::Piece;
use crate::{Error, Ray};

/// Contracted space, which this build omits: no value exists.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contracted {}

impl Contracted {
    pub(super) fn validate(&self) -> Result<(), Error> {
        match *self {}
    }

    pub(super) const fn bounds(&self) -> [[f32; 3]; 2] {
        match *self {}
    }

    pub(super) fn piece(&self, _: &Ray, _: f32) -> Option<Piece> {
        match *self {}
    }

    pub(super) fn length(&self, _: &Ray) -> f32 {
        match *self {}
    }

    pub(super) fn depth(&self, _: &Ray, _: f32) -> f32 {
        match *self {}
    }

    pub(super) fn scene_point(&self, _: [f32; 3]) -> [f32; 3] {
        match *self {}
    }

    pub(super) const fn viewing_distance(&self) -> f32 {
        match *self {}
    }

    /// Scene point to local point.
    #[must_use]
    pub fn local_point(&self, _: [f32; 3]) -> [f32; 3] {
        match *self {}
    }
}
