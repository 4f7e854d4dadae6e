//! Linear least squares of a few unknowns.

use crate::cameras::mount::PER_VIEW as N;

/// The equations AᵀA x = Aᵀb of the x for which A x is nearest to b.
pub(super) struct NormalEquations {
    matrix: [[f64; N]; N],
    right: [f64; N],
}

impl NormalEquations {
    /// Of the columns of A, and b.
    pub(super) fn new(columns: &[Vec<f32>], b: &[f32]) -> Self {
        let matrix = core::array::from_fn(|i| {
            core::array::from_fn(|j| dot(&columns[i.min(j)], &columns[i.max(j)]))
        });
        Self { matrix, right: core::array::from_fn(|i| dot(&columns[i], b)) }
    }

    /// Their solution, with a share of the diagonal added to it (Marquardt 1963), by Cholesky's
    /// decomposition; `None` where columns depend on each other.
    pub(super) fn solve(&self, damping: f64) -> Option<[f64; N]> {
        let mut lower = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                let rest = self.matrix[i][j] - known;
                lower[i][j] = match i == j {
                    false => rest / lower[j][j],
                    true => {
                        let square = rest + damping * self.matrix[i][i];
                        // Written so that NaN is refused too.
                        let sound = square > f64::EPSILON * self.matrix[i][i];
                        sound.then(|| square.sqrt())?
                    }
                };
            }
        }
        let mut x = self.right;
        for i in 0..N {
            let known: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
            x[i] = (x[i] - known) / lower[i][i];
        }
        for i in (0..N).rev() {
            let known: f64 = (i + 1..N).map(|k| lower[k][i] * x[k]).sum();
            x[i] = (x[i] - known) / lower[i][i];
        }
        Some(x)
    }
}

/// The sum of squares.
pub(super) fn square(values: &[f32]) -> f64 {
    dot(values, values)
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_by_hand() {
        // Unit columns but for the first two, which are (1, 1, 0 ...) and (0, 2, 0 ...).
        let mut columns = vec![vec![0.0; N + 1]; N];
        (0..N).for_each(|i| columns[i][i] = 1.0);
        columns[0][1] = 1.0;
        columns[1][1] = 2.0;
        // The last row is out of reach of all columns.
        let wanted = [3.0, -1.0, 0.5, 0.0, 7.0, -2.0];
        let mut b = vec![0.0; N + 1];
        for (column, x) in columns.iter().zip(wanted) {
            b.iter_mut().zip(column).for_each(|(b, a)| *b += a * x);
        }
        b[N] = 5.0;
        let equations = NormalEquations::new(&columns, &b);
        let found = equations.solve(0.0).unwrap();
        found.iter().zip(wanted).for_each(|(a, b)| assert!((a - f64::from(b)).abs() < 1e-6));
        // With as much again on the diagonal, a column on its own goes half of the way.
        assert!((equations.solve(1.0).unwrap()[4] - 3.5).abs() < 1e-6);
        // Columns that depend on each other have a solution if the diagonal is larger alone.
        columns[2] = columns[1].clone();
        let equations = NormalEquations::new(&columns, &b);
        assert!(equations.solve(0.0).is_none() && equations.solve(1e-3).is_some());
        columns[2].fill(f32::NAN);
        assert!(NormalEquations::new(&columns, &b).solve(1e-3).is_none());
    }
}
