//! Camera-to-world matrices from files: checked before anything uses them.

use std::fmt;

/// How far the lengths of a pose's axes may be from 1.
const SCALE_TOLERANCE: f64 = 1e-2;
/// How far the cosines between a pose's axes may be from those of a rotation.
const SHEAR_TOLERANCE: f64 = 1e-3;

/// What is wrong with a pose. The message is part of a line.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PoseProblem {
    /// Not four rows of four numbers.
    Shape {
        /// Numbers in each row.
        rows: Vec<usize>,
    },
    /// Not 16 numbers.
    Length(usize),
    /// A number is not finite, or not finite as `f32`.
    NonFinite,
    /// The last row is not 0, 0, 0, 1.
    LastRow([f64; 4]),
    /// The rotation part is no rotation.
    NotRigid {
        /// Determinant of the rotation part; a rotation has 1.
        determinant: f64,
        /// Largest difference between RᵀR, freed of its scale, and the identity.
        shear: f64,
    },
}

impl fmt::Display for PoseProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape { rows } => {
                write!(f, "the pose has {} rows", rows.len())?;
                if !rows.is_empty() && rows.len() <= 16 {
                    write!(f, " of {rows:?} numbers")?;
                }
                write!(f, ", expected 4 rows of 4 (camera-to-world)")
            }
            Self::Length(found) => {
                write!(f, "the pose has {found} numbers, expected 16 (camera-to-world)")
            }
            Self::NonFinite => {
                write!(f, "the pose holds a number that is not finite, expected finite numbers")
            }
            Self::LastRow(row) => write!(
                f,
                "the last row of the pose is {row:?}, expected [0, 0, 0, 1]; is the matrix transposed?"
            ),
            Self::NotRigid { determinant, shear } => write!(
                f,
                "the pose's 3x3 part is not a rotation: determinant {determinant:.6}, shear {shear:.2e}; expected determinant 1: \
                 take scale and mirroring out of the poses"
            ),
        }
    }
}

/// Checks a camera-to-world matrix given as rows: 4×4, finite and rigid.
/// Returns its 16 numbers, row after row.
///
/// # Errors
/// Says which of these does not hold.
pub fn from_rows(rows: &[Vec<f64>]) -> Result<[f32; 16], PoseProblem> {
    if rows.len() != 4 || rows.iter().any(|row| row.len() != 4) {
        return Err(PoseProblem::Shape { rows: rows.iter().map(Vec::len).collect() });
    }
    from_list(&rows.concat())
}

/// Checks a camera-to-world matrix given as a list, row after row: 16 numbers,
/// finite and rigid.
///
/// # Errors
/// Says which of these does not hold.
pub fn from_list(numbers: &[f64]) -> Result<[f32; 16], PoseProblem> {
    from_numbers(numbers.try_into().map_err(|_| PoseProblem::Length(numbers.len()))?)
}

fn from_numbers(m: &[f64; 16]) -> Result<[f32; 16], PoseProblem> {
    let pose = m.map(|x| x as f32);
    if pose.iter().any(|x| !x.is_finite()) {
        return Err(PoseProblem::NonFinite);
    }
    let last = [m[12], m[13], m[14], m[15]];
    if last.iter().zip([0.0, 0.0, 0.0, 1.0]).any(|(a, b)| (a - b).abs() > 1e-6) {
        return Err(PoseProblem::LastRow(last));
    }
    let axis = |column: usize| glam::DVec3::new(m[column], m[4 + column], m[8 + column]);
    let axes = [axis(0), axis(1), axis(2)];
    let determinant = axes[0].cross(axes[1]).dot(axes[2]);
    let scale = determinant.cbrt();
    let mut shear: f64 = 0.0;
    for (i, a) in axes.iter().enumerate() {
        for (j, b) in axes.iter().enumerate() {
            let identity = f64::from(u8::from(i == j));
            shear = shear.max((a.dot(*b) / (scale * scale) - identity).abs());
        }
    }
    // Written so that a NaN from a zero determinant is refused too.
    let rigid = (scale - 1.0).abs() <= SCALE_TOLERANCE && shear <= SHEAR_TOLERANCE;
    if rigid { Ok(pose) } else { Err(PoseProblem::NotRigid { determinant, shear }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: [f64; 16] = [1., 0., 0., 5., 0., 1., 0., 6., 0., 0., 1., 7., 0., 0., 0., 1.];

    fn with(changes: &[(usize, f64)]) -> Result<[f32; 16], PoseProblem> {
        let mut m = IDENTITY;
        for &(i, x) in changes {
            m[i] = x;
        }
        from_numbers(&m)
    }

    #[test]
    fn a_rigid_pose_is_taken_as_it_is() {
        assert_eq!(with(&[]).unwrap(), IDENTITY.map(|x| x as f32));
        // A camera turned by 90° about x.
        assert!(with(&[(5, 0.), (6, -1.), (9, 1.), (10, 0.)]).is_ok());
        // Rounded by an exporter.
        assert!(with(&[(0, 0.9999), (1, 2e-4)]).is_ok());
    }

    #[test]
    fn other_poses_are_refused() {
        let mirrored = with(&[(0, -1.)]).unwrap_err();
        assert!(mirrored.to_string().contains("determinant -1.000000"), "{mirrored}");
        for (changes, what) in [
            (&[(0, 2.), (5, 2.), (10, 2.)][..], "scaled"),
            (&[(1, 0.01)], "sheared"),
            (&[(0, 0.)], "flat"),
            (&[(0, 0.), (5, 0.), (10, 0.)], "zero"),
        ] {
            assert!(matches!(with(changes), Err(PoseProblem::NotRigid { .. })), "{what}");
        }
        assert_eq!(with(&[(3, f64::NAN)]), Err(PoseProblem::NonFinite));
        assert_eq!(with(&[(3, 1e300)]), Err(PoseProblem::NonFinite));
        assert!(matches!(with(&[(3, 0.), (12, 5.)]), Err(PoseProblem::LastRow(_))));
    }

    #[test]
    fn the_shape_is_said() {
        let problem = from_rows(&[vec![0.0; 4], vec![0.0; 4], vec![0.0; 3]]).unwrap_err();
        assert_eq!(
            problem.to_string(),
            "the pose has 3 rows of [4, 4, 3] numbers, expected 4 rows of 4 (camera-to-world)"
        );
    }
}
