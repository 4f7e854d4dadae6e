//! What is wrong with a ray: a file a term.
//!
//! A term sees what the ray has accumulated and gives its gradient with respect to that;
//! how it goes on from there to samples and parameters is the step's business.

mod squared_error;

use std::fmt::Debug;

use super::TrainingRay;
use squared_error::squared_error;

/// Terms beside the squared error of the colour. A new one is a file here and a line in
/// this list.
pub(crate) const TERMS: &[&dyn Term] = &[];

/// What a ray has accumulated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rendered {
    /// Colour over the mean background.
    pub(crate) color: [f32; 3],
    /// Opacity.
    pub(crate) opacity: f32,
    /// Sum of the samples' weights times their distances.
    #[cfg_attr(not(test), expect(dead_code, reason = "the squared error of colours is all"))]
    pub(crate) depth: f32,
}

/// What is wrong with a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLoss {
    /// Squared error of the colour, summed over the channels: for statistics, and for where
    /// rays are drawn.
    pub(crate) squared_error: f32,
    /// Gradient by the colour over the mean background.
    pub(crate) d_color: [f32; 3],
    /// And by the opacity where that colour stays the same.
    pub(crate) d_opacity: f32,
    /// And by the depth.
    pub(crate) d_depth: f32,
    /// And by the logarithm of the factor by which each channel is brighter in the photograph.
    pub(crate) d_log_gain: [f32; 3],
}

/// A term of the loss.
pub(crate) trait Term: Debug + Sync {
    /// Whether it needs the depth, or has a gradient by it.
    fn needs_depth(&self) -> bool {
        false
    }

    /// Adds the gradients, times the weight of the ray.
    fn add(&self, ray: &TrainingRay, rendered: &Rendered, loss: &mut RayLoss);
}

/// All terms together.
#[inline(always)]
pub(crate) fn loss(terms: &[&dyn Term], ray: &TrainingRay, rendered: &Rendered) -> RayLoss {
    let mut loss = squared_error(ray, rendered);
    for term in terms {
        term.add(ray, rendered, &mut loss);
    }
    loss
}
