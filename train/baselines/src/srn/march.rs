//! The way of a ray, there and back.

use ndarray::{Array2, ArrayView2, Axis, s};
use pocketnerf_core::Ray;

use super::Networks;
use crate::network::{LstmTape, MlpTape, Real};
use crate::photographs::Place;

/// Weight of the term that keeps depths from becoming negative.
const BEHIND: f64 = 1.0;
/// Where rays begin: this far before they come nearest to the middle of the scene, in half
/// sides of its cube, or at the camera.
pub(super) const BEFORE: f32 = 1.75;

/// What a batch of rays has met.
pub(super) struct Pass<T> {
    directions: Array2<T>,
    /// Distances from where the rays begin.
    depths: Array2<T>,
    steps: Vec<Step<T>>,
    last: MlpTape<T>,
    color: MlpTape<T>,
    /// What the last layer got.
    features: Array2<T>,
    /// sRGB, a row a ray.
    pub(super) colors: Array2<T>,
}

/// One step of all rays.
struct Step<T> {
    point: MlpTape<T>,
    memory: LstmTape<T>,
    hidden: Array2<T>,
}

impl Networks {
    pub(super) fn forward<T: Real>(
        &self,
        parameters: &[T],
        place: &Place,
        rays: &[Ray],
    ) -> Pass<T> {
        let n = rays.len();
        let (mut points, mut directions) = (Array2::zeros((n, 3)), Array2::zeros((n, 3)));
        for (i, ray) in rays.iter().enumerate() {
            let [origin, direction] = place.ray(ray);
            let nearest = -origin.dot(direction);
            let begin = origin + direction * (nearest - BEFORE).max(0.0);
            for a in 0..3 {
                points[[i, a]] = T::of(f64::from(begin[a]));
                directions[[i, a]] = T::of(f64::from(direction[a]));
            }
        }
        let mut state = self.memory.empty(n);
        let mut depths = Array2::zeros((n, 1));
        let mut steps = Vec::with_capacity(self.config.steps as usize);
        for _ in 0..self.config.steps {
            let (features, point) = self.points.forward(parameters, points.clone());
            let (next, memory) = self.memory.forward(parameters, &features.view(), &state);
            let length = self.length.forward(parameters, &next[0].view());
            points += &(&directions * &length);
            depths += &length;
            steps.push(Step { point, memory, hidden: next[0].clone() });
            state = next;
        }
        let (features, last) = self.points.forward(parameters, points);
        let (features, color) = self.colors.forward(parameters, features);
        let colors = self.out.forward(parameters, &features.view());
        Pass { directions, depths, steps, last, color, features, colors }
    }

    /// The penalty of depths that are negative.
    #[cfg(test)]
    pub(super) fn penalty<T: Real>(pass: &Pass<T>) -> T {
        pass.depths.iter().map(|depth| depth.min(T::zero()).powi(2)).sum::<T>() * T::of(BEHIND)
    }

    /// Adds to the gradient of the parameters. `weight` is that of a ray's penalty.
    pub(super) fn backward<T: Real>(
        &self,
        parameters: &[T],
        pass: &Pass<T>,
        d_colors: &Array2<T>,
        weight: T,
        gradient: &mut [T],
    ) {
        let d = self.out.backward(parameters, &pass.features.view(), &d_colors.view(), gradient);
        let d = self.colors.backward(parameters, &pass.color, d, gradient);
        let mut d_points = self.points.backward(parameters, &pass.last, d, gradient);
        let twice = T::of(2.0 * BEHIND) * weight;
        let d_depths = pass.depths.mapv(|depth| twice * depth.min(T::zero()));
        let mut d_state = self.memory.empty(d_points.nrows());
        for step in pass.steps.iter().rev() {
            let along = along(&d_points.view(), &pass.directions) + &d_depths;
            let d_hidden =
                self.length.backward(parameters, &step.hidden.view(), &along.view(), gradient);
            d_state[0] += &d_hidden;
            let (d_features, before) =
                self.memory.backward(parameters, &step.memory, &d_state, gradient);
            d_points += &self.points.backward(parameters, &step.point, d_features, gradient);
            d_state = before;
        }
    }
}

/// Products of the rows of two matrices, a column.
fn along<T: Real>(a: &ArrayView2<'_, T>, b: &Array2<T>) -> Array2<T> {
    (a * b).sum_axis(Axis(1)).slice(s![.., ndarray::NewAxis]).to_owned()
}
