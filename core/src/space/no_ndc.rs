//! Builds without normalised device coordinates: there are none, and nothing to link.

use crate::{Error, Ray};

/// Normalised device coordinates, which this build omits: no value exists.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ndc {}

impl Ndc {
    pub(super) fn validate(&self) -> Result<(), Error> {
        match *self {}
    }

    pub(super) const fn bounds(&self) -> [[f32; 3]; 2] {
        match *self {}
    }

    pub(super) fn length(&self, _: &Ray) -> f32 {
        match *self {}
    }

    pub(super) fn local(&self, _: &Ray) -> Option<Ray> {
        match *self {}
    }

    pub(super) fn depth(&self, _: &Ray, _: f32) -> f32 {
        match *self {}
    }

    pub(super) fn scene_point(&self, _: [f32; 3]) -> [f32; 3] {
        match *self {}
    }
}
