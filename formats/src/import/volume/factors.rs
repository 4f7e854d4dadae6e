//! Products of planes and lines, their components side by side.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use super::tensorf::MOST;
use crate::import::FieldError;
use crate::import::settings::setting;
use crate::import::tensors::{Tensors, shape, values};

/// The axes across which planes lie: (column, row) of planes 0 to 2; the lines are along the
/// remaining ones, 2, 1 and 0.
const PLANES: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

/// Products of values that are interpolated on planes and lines.
#[derive(Clone, Debug)]
pub struct Factors {
    /// Products of each plane and its line; of lines alone: of all three, the first counts.
    pub components: [usize; 3],
    /// `[rows][columns][components]` each; `None`: lines alone, products of three values.
    pub planes: Option<[Vec<f32>; 3]>,
    /// `[entries][components]` each, along z, y and x; of lines alone along z, y and x, too.
    pub lines: [Vec<f32>; 3],
}

impl Factors {
    /// The axes (column, row) of a plane.
    #[must_use]
    pub const fn plane_axes(plane: usize) -> [usize; 2] {
        PLANES[plane]
    }

    /// The axis of a line.
    #[must_use]
    pub const fn line_axis(line: usize) -> usize {
        2 - line
    }

    /// How many products there are.
    #[must_use]
    pub fn n_products(&self) -> usize {
        match self.planes {
            Some(_) => self.components.iter().sum(),
            None => self.components[0],
        }
    }
}

/// The planes and lines of densities or of colours.
pub(super) fn factors(
    tensors: &mut Tensors<'_, '_>,
    of: &str,
    sizes: [usize; 3],
) -> Result<Factors, FieldError> {
    let with_planes = tensors.has(&format!("{of}_plane.0"));
    let mut components = [0; 3];
    let mut lines = [const { Vec::new() }; 3];
    let mut planes = [const { Vec::new() }; 3];
    for i in 0..3 {
        let along = sizes[Factors::line_axis(i)];
        (components[i], lines[i]) = side_by_side(tensors, &format!("{of}_line.{i}"), [along, 1])?;
        if with_planes {
            let [column, row] = Factors::plane_axes(i).map(|axis| sizes[axis]);
            let name = format!("{of}_plane.{i}");
            let (count, values) = side_by_side(tensors, &name, [row, column])?;
            if count != components[i] {
                let found = count.to_string();
                return Err(setting(&name, &found, &format!("{} components", components[i])));
            }
            planes[i] = values;
        }
    }
    if !with_planes && components != [components[0]; 3] {
        return Err(setting(of, &format!("{components:?}"), "lines of as many components"));
    }
    Ok(Factors { components, planes: with_planes.then_some(planes), lines })
}

/// The values of a tensor `[1, components, rows, columns]` as `[rows][columns][components]`, and
/// how many components there are.
fn side_by_side(
    tensors: &mut Tensors<'_, '_>,
    name: &str,
    [rows, columns]: [usize; 2],
) -> Result<(usize, Vec<f32>), FieldError> {
    let (name, tensor) = tensors.take(name)?;
    let n = match *tensor.shape() {
        [1, n, r, c] if [r, c] == [rows, columns] && (1..=MOST).contains(&n) => n,
        _ => return Err(shape(name, tensor, format!("[1, 1 to {MOST}, {rows}, {columns}]"))),
    };
    let values = values(name, tensor)?;
    let entries = rows * columns;
    Ok((n, (0..n * entries).map(|i| values[i % n * entries + i / n]).collect()))
}
