//! What is learnt of the photographs beside the field: where their cameras are, and how bright they
//! are.

use pocketnerf_core::Camera;

use super::pixels::rays::RaySource;
use super::run::checkpoint::kind;
use super::{TrainConfig, Trainer, gains};

/// The number of photographs whose gains are learnt with the field, where they are evened out.
pub(super) fn learnt_gains(source: &RaySource, config: &TrainConfig) -> Option<usize> {
    let gains = source.exposure().gains().len();
    (gains > 0 && config.hierarchical_training().is_none()).then_some(gains)
}

impl Trainer {
    /// Whether photographs are evened out, see
    /// [`Prepared::even_exposure`](super::prepass::Prepared::even_exposure).
    #[must_use]
    pub fn is_evened_out(&self) -> bool {
        !self.source.exposure().gains().is_empty()
    }

    /// How many fields were trained before, whose mean is learnt beside the photographs, see
    /// [`Prepared::taught`](super::prepass::Prepared::taught).
    #[must_use]
    pub fn n_teachers(&self) -> usize {
        self.source.teachers().len()
    }

    /// By how much each camera was turned, degrees, and moved, shares of the cameras' mean distance
    /// from the scene; `None` where poses are not refined.
    #[must_use]
    pub fn pose_corrections(&self) -> Option<Vec<[f32; 2]>> {
        let group = self.backend.download().group(kind::POSES)?;
        self.poses.as_ref().map(|poses| poses.sizes(&group.parameters))
    }

    /// The photographs' cameras, that rays start from: as they were given, or with their corrections.
    #[must_use]
    pub fn cameras(&self) -> &[Camera] {
        self.source.photographs()
    }

    /// From now on rays start from where the cameras are thought to be, and photographs are as
    /// bright as they are thought to be.
    pub(super) fn correct_photographs(&mut self) {
        if self.poses.is_none() && !self.is_evened_out() {
            return;
        }
        let state = self.backend.download();
        if let (Some(poses), Some(group)) = (&self.poses, state.group(kind::POSES)) {
            self.source.move_cameras(poses.cameras(&group.parameters));
        }
        if let Some(group) = state.group(kind::GAINS) {
            self.source.brighten(gains::factors(&group.parameters));
        }
    }

    /// Photographs are evened out by what was learnt of them from now on.
    pub(super) fn keep_gains(&mut self) {
        if !self.is_evened_out() || self.backend.download().group(kind::GAINS).is_none() {
            return;
        }
        let mut state = self.backend.download().clone();
        let Some(group) = state.group_mut(kind::GAINS) else { return };
        let given = self.source.exposure().gains().iter();
        let total = given.zip(gains::factors(&group.parameters));
        let total = total.map(|(given, own)| [0, 1, 2].map(|c| given[c] / own[c])).collect();
        group.parameters.fill(0.0);
        self.source.even_out(total);
        self.backend.upload(state);
    }
}
