//! How far it is to what a ray sees.

use core::ops::ControlFlow;

use crate::march::{MAX_STEPS, Marcher};
use crate::query::Probe;
use crate::query::points::{DIRECTION, check_output, check_points, unit};
use crate::query::transmittance::check_number;
use crate::{Error, Ray, math};

/// What counts as the depth of a ray that sees more than one thing. With T the light that
/// still passes at distance t, and the model's own samples at `t_k`, steps of δ apart:
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth {
    /// The mean over what is seen, `Σ w_k t_k / Σ w_k` with `w_k = T_k (1 - exp(-σ_k δ))`,
    /// as in a rendered depth (Mildenhall et al. 2020, equation 3). Between a pane and the
    /// wall behind it lies the mean of both, where nothing is.
    Expected,
    /// Where half of the light has been held back, T = 1/2: on one of the things that are seen,
    /// the one in the middle.
    Median,
    /// The first sample whose sigma, 1 / unit, is larger than this: transparent things too
    /// (Dex-NeRF, Ichnowski et al., arXiv 2110.14217, which takes 15 in the units of its
    /// scenes). Sigma depends on the unit of length, and the threshold with it.
    FirstSigma(f32),
    /// Where this part of the light, from 1e-6 to below 1, has been held back:
    /// `T = 1 - opacity`.
    FirstOpacity(f32),
}

impl Depth {
    fn validate(&self) -> Result<(), Error> {
        let sound = match self {
            Self::Expected | Self::Median => true,
            Self::FirstSigma(sigma) => sigma.is_finite() && *sigma >= 0.0,
            Self::FirstOpacity(opacity) => (1e-6..1.0).contains(opacity),
        };
        sound.then_some(()).ok_or(Error::Range("depth: a sigma from 0, an opacity from 0 to 1"))
    }
}

impl Probe<'_> {
    /// The depth of what each of `rays` sees, into one value each of `out`, the caller's
    /// units; infinite where it sees nothing of the kind.
    ///
    /// Without `axis`, depths are distances from the rays' origins. With it, a unit vector
    /// such as [`Camera::axis`](crate::Camera::axis), they are distances along it, as in
    /// most depth images: the distance times the cosine of the ray and the axis.
    ///
    /// Rays are sampled as pictures are, from the model's `near` to its `far` in its own
    /// steps δ, each with the density of its middle. So a wall that light cannot pass is
    /// found within δ/2 of where it stands, and one that a sigma tells less than δ behind.
    ///
    /// # Errors
    /// As [`density`](Self::density); [`Error::Range`] for a direction or an axis that goes
    /// nowhere, and for thresholds without meaning.
    pub fn depths(
        &self,
        rays: &[Ray],
        depth: Depth,
        axis: Option<[f32; 3]>,
        scratch: &mut [f32],
        out: &mut [f32],
    ) -> Result<(), Error> {
        depth.validate()?;
        check_output(rays.len(), out.len())?;
        check_number(rays.len())?;
        for ray in rays {
            check_points(&[ray.origin])?;
            unit(ray.direction).ok_or(DIRECTION)?;
        }
        let axis = axis.map(|axis| unit(axis).ok_or(DIRECTION)).transpose()?;
        let mut scratch = self.cut(scratch)?;
        let marcher = Marcher::new(self.model, true);
        let start = |i: usize| {
            let origin = self.similarity.to_model(rays[i].origin);
            let direction = self.similarity.to_model_direction(rays[i].direction);
            unit(direction).map(|direction| (Ray { origin, direction }, MAX_STEPS as f32))
        };
        let (step, scale) = (self.model.sampling.step, self.similarity.scale);
        let ends = self.model.sampling.min_transmittance;
        out.fill(f32::INFINITY);
        self.march(&marcher, rays.len(), &mut scratch, start, |seen, t, sigma| {
            let out = &mut out[seen.number];
            let transmitted = || math::exp(-sigma * step);
            let passes = match depth {
                Depth::Expected => {
                    seen.accumulated.add(1.0 - transmitted(), t);
                    *out = seen.accumulated.expected_depth();
                    return go_on(seen.accumulated.transmittance >= ends);
                }
                Depth::FirstSigma(least) => {
                    let is_met = sigma > least * scale;
                    if is_met {
                        *out = t;
                    }
                    return go_on(!is_met);
                }
                Depth::Median => 0.5,
                Depth::FirstOpacity(opacity) => 1.0 - opacity,
            };
            let before = seen.accumulated.transmittance;
            seen.accumulated.transmittance *= transmitted();
            let is_met = seen.accumulated.transmittance <= passes;
            if is_met {
                *out = t + (math::ln(before / passes) / sigma).min(step) - 0.5 * step;
            }
            go_on(!is_met)
        });
        for (out, ray) in out.iter_mut().zip(rays) {
            let cosine = match (axis, unit(ray.direction)) {
                (Some(axis), Some(d)) => axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2],
                _ => 1.0,
            };
            if out.is_finite() {
                *out *= scale * cosine;
            }
        }
        Ok(())
    }
}

fn go_on(does: bool) -> ControlFlow<()> {
    if does { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}
