//! How density changes from place to place, and where surfaces face.

use core::array::from_fn;

use crate::Error;
use crate::field::AnyField;
use crate::query::Probe;
use crate::query::evaluate::Wanted;
use crate::query::points::{check_output, check_points, unit};

impl Probe<'_> {
    /// The gradient of sigma at `points`, into one vector each of `out`: 1 / unit², the
    /// caller's axes; 0 outside the model's box and in empty cells.
    ///
    /// Central differences along each axis of the model: `(σ(u + h) - σ(u - h)) / 2h`, with
    /// h = [`step`](Self::gradient_step), a sixteenth of what the field can resolve, cut
    /// off at the faces of the box. They differ from the derivative by h²/6 times the third
    /// one, a part in 600 of the steepest wave; within h of a wall of a hash grid's cells,
    /// where the derivative jumps, they are a mean of both sides. Rounding adds up to
    /// 2e-6 σ/h. Six evaluations a point.
    ///
    /// It is the field's own density that is differentiated, which goes on behind the walls
    /// of occupied cells; that it is cut off there is no slope.
    ///
    /// # Errors
    /// As [`density`](Self::density).
    pub fn density_gradient(
        &self,
        points: &[[f32; 3]],
        scratch: &mut [f32],
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        check_output(points.len(), out.len())?;
        check_points(points)?;
        let mut scratch = self.cut(scratch)?;
        let around = |i: usize| self.around(points[i]);
        let n = points.len();
        self.each(n, Wanted::Density, None, &mut scratch, around, |i, answers| {
            let Some(around) = self.around(points[i]) else {
                out[i] = [0.0; 3];
                return;
            };
            // Densities go up to e^15, and steps down to 1e-6: more than f32's range.
            let slope = |axis: usize| {
                let [low, high] = [2 * axis, 2 * axis + 1];
                let rise = f64::from(answers[high][3]) - f64::from(answers[low][3]);
                let run = f64::from(around[high][axis]) - f64::from(around[low][axis]);
                if run > 0.0 { rise / run * f64::from(self.map.scale) } else { 0.0 }
            };
            let slopes = [slope(0), slope(1), slope(2)];
            let scale = f64::from(self.similarity.scale);
            out[i] = self.similarity.rotation.map(|row| {
                let along: f64 = row.iter().zip(slopes).map(|(r, s)| f64::from(*r) * s).sum();
                ((along / (scale * scale)) as f32).clamp(f32::MIN, f32::MAX)
            });
        });
        Ok(())
    }

    /// Half of the distance between the two points that a difference is taken of, the
    /// caller's units.
    #[must_use]
    pub fn gradient_step(&self) -> f32 {
        self.spacing / self.map.scale * self.similarity.scale
    }

    /// The unit points before and behind a point along each axis.
    fn around(&self, point: [f32; 3]) -> Option<[[f32; 3]; 6]> {
        let u = self.place(point)?;
        let top = self.map.apply(self.model.space.bounds()[1]);
        Some(from_fn(|k| {
            let (mut moved, axis) = (u, k / 2);
            moved[axis] = match k % 2 {
                0 => (u[axis] - self.spacing).max(0.0),
                _ => (u[axis] + self.spacing).min(top[axis]),
            };
            moved
        }))
    }
}

/// Where a surface faces that has this density gradient: downhill, a unit vector; zeros
/// where there is no slope.
#[must_use]
pub fn normal(gradient: [f32; 3]) -> [f32; 3] {
    unit(gradient).map_or([0.0; 3], |up| up.map(|v| 0.0 - v))
}

/// How far beyond a point [`Probe::density_gradient`] evaluates the field, unit coordinates: a
/// sixteenth of a hash grid's finest cells, or of a quarter of the shortest wave. Never so little
/// that rounding shows.
#[must_use]
pub fn gradient_spacing(field: &AnyField<'_>) -> f32 {
    const LEAST: f32 = 1.0 / (1 << 20) as f32;
    (field.finest_detail() / 16.0).clamp(LEAST, 1.0 / 64.0)
}
