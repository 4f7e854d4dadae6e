//! Density and radiance of points.

use core::array::from_fn;

use glam::Vec3;

use crate::query::Probe;
use crate::query::evaluate::Wanted;
use crate::query::similarity::are_places;
use crate::scratch::Scratch;
use crate::{Error, math};

impl Probe<'_> {
    /// Sigma at `points`, into one value each of `out`: 1 / unit; 0 outside the model's box
    /// and in empty cells, where the field is not evaluated.
    ///
    /// Sigma is what volume rendering means by it (Mildenhall et al. 2020, section 4): the
    /// part of the light that is held back on a short way of length δ is σδ. It changes
    /// with the unit of length: in centimetres it is a hundredth of what it is in metres.
    ///
    /// # Errors
    /// [`Error::Range`] for a point that is nowhere (NaN, infinite or beyond 1e11 units),
    /// [`Error::OutputLength`], [`Error::ScratchTooSmall`]. Nothing is written then.
    pub fn density(
        &self,
        points: &[[f32; 3]],
        scratch: &mut [f32],
        out: &mut [f32],
    ) -> Result<(), Error> {
        check_output(points.len(), out.len())?;
        check_points(points)?;
        let mut scratch = self.cut(scratch)?;
        let place = |i: usize| self.place(points[i]).map(|u| [u]);
        let scale = self.similarity.scale;
        self.each(points.len(), Wanted::Density, None, &mut scratch, place, |i, [answer]| {
            out[i] = answer[3] / scale;
        });
        Ok(())
    }

    /// Colour and sigma of `points`, seen along `directions`, into `[r, g, b, sigma]` each
    /// of `out`. Colours are straight, from 0 to 1, in the model's colour space; sigma is
    /// as for [`density`](Self::density). All four are 0 outside the model's box and in
    /// empty cells. Of directions, towards the points, only where they go matters.
    ///
    /// A field that decodes colour once a ray is evaluated as if the ray met nothing but the
    /// point: the shade of that point alone. A picture shades the mean of what its ray has
    /// met instead, so that the two differ where that is not all alike.
    ///
    /// # Errors
    /// As [`density`](Self::density); [`Error::InputLength`] unless there are as many
    /// directions as points, [`Error::Range`] for one that goes nowhere.
    pub fn radiance(
        &self,
        points: &[[f32; 3]],
        directions: &[[f32; 3]],
        scratch: &mut [f32],
        out: &mut [[f32; 4]],
    ) -> Result<(), Error> {
        check_output(points.len(), out.len())?;
        if directions.len() != points.len() {
            let (needed, given) = (points.len(), directions.len());
            return Err(Error::InputLength { needed, given });
        }
        check_points(points)?;
        if !directions.iter().all(|d| unit(*d).is_some()) {
            return Err(DIRECTION);
        }
        let mut scratch = self.cut(scratch)?;
        let place = |i: usize| self.place(points[i]).map(|u| [u]);
        let (scale, n) = (self.similarity.scale, points.len());
        self.each(n, Wanted::Radiance, Some(directions), &mut scratch, place, |i, [answer]| {
            let [r, g, b, sigma] = *answer;
            out[i] = [r, g, b, sigma / scale];
        });
        Ok(())
    }

    /// The probability that a body hits something: `1 - exp(-Σ σ(p) volume /
    /// particle_area)` over the `points` that fill the body, each of which stands for
    /// `volume`, unit³.
    ///
    /// After CATNIPS (Chen et al., arXiv 2302.12931): a field is a Poisson process of small
    /// particles whose cross section is `particle_area`, A, in unit². A ray is held back
    /// by σ = λA for an intensity of λ particles a unit³ (Max 1995), so that λ = σ/A, and
    /// the body meets none with the probability exp(-∫ λ dV). A field does not determine A:
    /// it says how large a thing must be to matter. A quarter of the area is four times as
    /// many particles and the logarithm of the probability to pass times four.
    ///
    /// # Errors
    /// As [`density`](Self::density); [`Error::Range`] for a volume below 0 or an area that
    /// is not above it.
    pub fn collision_probability(
        &self,
        points: &[[f32; 3]],
        volume: f32,
        particle_area: f32,
        scratch: &mut [f32],
    ) -> Result<f32, Error> {
        let sound =
            volume >= 0.0 && particle_area > 0.0 && volume.is_finite() && particle_area.is_finite();
        if !sound {
            return Err(Error::Range("volume of a point and area of a particle"));
        }
        check_points(points)?;
        let mut scratch = self.cut(scratch)?;
        let place = |i: usize| self.place(points[i]).map(|u| [u]);
        let mut sum = 0.0;
        self.each(points.len(), Wanted::Density, None, &mut scratch, place, |_, [answer]| {
            sum += f64::from(answer[3]);
        });
        let per_sigma =
            f64::from(volume) / (f64::from(particle_area) * f64::from(self.similarity.scale));
        let particles = (sum * per_sigma) as f32;
        // 1 - exp(-x) would lose the digits of a small probability.
        Ok(match particles < 0.01 {
            true => particles * (1.0 - particles / 2.0 * (1.0 - particles / 3.0)),
            false => 1.0 - math::exp(-particles),
        })
    }

    /// The unit coordinates of a point where the model may hold something: inside the box,
    /// its faces included, and in an occupied cell.
    #[inline]
    pub(super) fn place(&self, point: [f32; 3]) -> Option<[f32; 3]> {
        self.model.place(&self.map, self.similarity.to_model(point))
    }

    /// Evaluates the N unit points that `place` returns for each of `n` things, and passes on
    /// the answers, `[r, g, b, sigma]` in the model's units; zeros of what has no place.
    /// Batches are full, whatever lies between their points.
    pub(super) fn each<const N: usize>(
        &self,
        n: usize,
        wanted: Wanted,
        directions: Option<&[[f32; 3]]>,
        scratch: &mut Scratch<'_>,
        place: impl Fn(usize) -> Option<[[f32; 3]; N]>,
        mut tell: impl FnMut(usize, &[[f32; 4]; N]),
    ) {
        let room = self.room(wanted, scratch) / N;
        // Things that wait, and the first of those that may: numbers count from there.
        let (mut waiting, mut first) = (0, 0);
        for i in 0..n {
            if let Some(points) = place(i) {
                for (s, u) in (N * waiting..).zip(points) {
                    scratch.samples.points.iter_mut().zip(u).for_each(|(row, u)| row[s] = u);
                }
                if let Some(directions) = directions {
                    let d = self.similarity.to_model_direction(directions[i]);
                    let d = unit(d).unwrap_or_default();
                    scratch
                        .samples
                        .directions
                        .iter_mut()
                        .zip(d)
                        .for_each(|(row, d)| row[waiting] = d);
                }
                scratch.slots.runs[waiting] = (i - first) as u32;
                waiting += 1;
            } else {
                tell(i, &[[0.0; 4]; N]);
            }
            if waiting == room || (i + 1 == n && waiting > 0) {
                let stride = self.evaluate(wanted, N * waiting, scratch);
                let output = &*scratch.work.output;
                for (w, number) in scratch.slots.runs[..waiting].iter().enumerate() {
                    let answers = from_fn(|k| {
                        let color = |c: usize| match wanted {
                            Wanted::Density => 0.0,
                            Wanted::Radiance => output[c * stride + N * w + k],
                        };
                        [color(1), color(2), color(3), output[N * w + k]]
                    });
                    tell(first + *number as usize, &answers);
                }
                (waiting, first) = (0, i + 1);
            }
        }
    }
}

/// What is wrong with a direction.
pub(super) const DIRECTION: Error = Error::Range("a direction: finite, and not zero");

/// The unit vector along `d`; `None` where it goes nowhere.
pub(super) fn unit(d: [f32; 3]) -> Option<[f32; 3]> {
    // By its largest part first: squares of tiny and huge numbers leave f32's range.
    let d = Vec3::from(d);
    let largest = d.abs().max_element();
    (d.is_finite() && largest > 0.0)
        .then(|| (d / largest).normalize_or_zero().to_array())
        .filter(|d| *d != [0.0; 3])
}

/// Refuses points that are nowhere.
pub(super) fn check_points(points: &[[f32; 3]]) -> Result<(), Error> {
    let sound = are_places(points.as_flattened());
    sound.then_some(()).ok_or(Error::Range("a point: finite, and within 1e11 units"))
}

/// Refuses outputs that are not as long as they have to be.
pub(super) fn check_output(needed: usize, given: usize) -> Result<(), Error> {
    (needed == given).then_some(()).ok_or(Error::OutputLength { needed, given })
}
