//! How much light passes from one point to another.

use core::ops::ControlFlow;

use glam::Vec3;

use crate::march::{MAX_STEPS, Marcher};
use crate::query::Probe;
use crate::query::points::{check_output, check_points};
use crate::{Error, Ray, Sampling, math};

impl Probe<'_> {
    /// The part of the light that passes along each of `segments`, from its first point to
    /// its second: `exp(-∫ σ dt)`, into one value each of `out`. 1: nothing is in the way.
    ///
    /// The part of a segment inside the model's box is cut into as few equal steps as are
    /// not longer than the model's own, and each counts as its middle does (the midpoint
    /// rule) where that lies in an occupied cell. So a density that is the same all along
    /// counts exactly, and the wall of an occupied cell by up to half a step too near or
    /// too far. Segments of more than 2^20 steps have longer ones.
    ///
    /// # Errors
    /// As [`density`](Self::density).
    pub fn segment_transmittance(
        &self,
        segments: &[[[f32; 3]; 2]],
        scratch: &mut [f32],
        out: &mut [f32],
    ) -> Result<(), Error> {
        check_output(segments.len(), out.len())?;
        check_points(segments.as_flattened())?;
        check_number(segments.len())?;
        let mut scratch = self.cut(scratch)?;
        // Distances count steps, which are of another length for each segment.
        let far = MAX_STEPS as f32;
        let steps = Sampling { step: 1.0, near: 0.0, far, min_transmittance: 0.0 };
        let marcher = Marcher::from_parts(self.model.occupancy, self.model.space, steps, true);
        let start = |i: usize| self.course(segments[i]).map(|course| (course.ray, course.steps));
        out.fill(0.0);
        self.march(&marcher, segments.len(), &mut scratch, start, |seen, _, sigma| {
            out[seen.number] += sigma;
            ControlFlow::Continue(())
        });
        for (out, segment) in out.iter_mut().zip(segments) {
            let step = self.course(*segment).map_or(0.0, |course| course.step);
            *out = math::exp(-*out * step);
        }
        Ok(())
    }

    /// The steps of a segment inside the box, where it has any length there.
    fn course(&self, segment: [[f32; 3]; 2]) -> Option<Course> {
        let [from, to] = segment.map(|p| Vec3::from(self.similarity.to_model(p)));
        let length = (to - from).length();
        let direction = (to - from).try_normalize()?;
        let ray = Ray { origin: from.to_array(), direction: direction.to_array() };
        let [t0, t1] = self.model.space.intersect(&ray, 0.0, length)?;
        // One more than whole steps, at least 1.
        let steps = ((t1 - t0) / self.model.sampling.step) as u32;
        let steps = (steps.min(MAX_STEPS - 2) + 1) as f32;
        let step = (t1 - t0) / steps;
        let origin = (from + direction * t0).to_array();
        let ray = Ray { origin, direction: (direction * step).to_array() };
        (step > 0.0).then_some(Course { ray, steps, step })
    }
}

/// A segment's part inside the box.
struct Course {
    /// From its beginning, a step long.
    ray: Ray,
    /// A whole number.
    steps: f32,
    /// Length of a step, the model's units.
    step: f32,
}

/// Refuses more rays than can be numbered.
pub(super) fn check_number(n: usize) -> Result<(), Error> {
    u32::try_from(n).map(|_| ()).map_err(|_| Error::Range("number of rays"))
}
