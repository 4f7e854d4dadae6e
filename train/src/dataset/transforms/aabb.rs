//! The box of the scene, where instant-ngp's keys give one.

use std::path::Path;

use serde_json::Value;

use super::RawFile;
use crate::dataset::DatasetError;

/// A cube of this side around its middle is instant-ngp's unit cube in the file's world,
/// with `scale` 0.33 and `offset` 0.5.
const SCALE: f64 = 0.33;
/// The largest `aabb_scale`.
const LARGEST: f64 = 128.0;

/// The box in the file's own world, smallest and largest corner.
///
/// instant-ngp maps a point p to p · scale + offset, then cycles its axes, and looks at
/// a cube of side `aabb_scale` around (0.5, 0.5, 0.5): cycled axes leave that as it is, so
/// p lies between (0.5 ± aabb_scale / 2 − offset) / scale. `aabb` takes the place of both:
/// the cube around that box becomes the unit cube. Without an `aabb_scale`, or with 1,
/// the box itself is the scene's.
pub(super) fn scene_box(raw: &RawFile, file: &Path) -> Result<Option<[[f32; 3]; 2]>, DatasetError> {
    let refuse = |key: &'static str, expected: &'static str| {
        Err(DatasetError::Box { file: file.to_owned(), key, expected })
    };
    let RawFile { aabb_scale, scale, offset, aabb, .. } = raw;
    if aabb_scale.is_none() && scale.is_none() && offset.is_none() && aabb.is_none() {
        return Ok(None);
    }
    let side = aabb_scale.unwrap_or(1.0);
    if !(side > 0.0 && side <= LARGEST) {
        return refuse("aabb_scale", "a number above 0, at most 128");
    }
    let corners = if let Some(aabb) = aabb {
        let Some([min, max]) = corners(aabb) else {
            return refuse("aabb", "[[x, y, z], [x, y, z]], the smallest corner first");
        };
        let middle = [0, 1, 2].map(|a| 0.5 * (min[a] + max[a]));
        let longest = (0..3).map(|a| max[a] - min[a]).fold(0.0, f64::max);
        if side <= 1.0 {
            [min, max]
        } else {
            [middle.map(|m| m - 0.5 * side * longest), middle.map(|m| m + 0.5 * side * longest)]
        }
    } else {
        let scale = scale.unwrap_or(SCALE);
        if !(1e-6..1e6).contains(&scale) {
            return refuse("scale", "a number above 0");
        }
        let Some(offset) = offset.as_ref().map_or(Some([0.5; 3]), three) else {
            return refuse("offset", "a number or three");
        };
        [-0.5, 0.5].map(|end| offset.map(|offset| (0.5 + end * side - offset) / scale))
    };
    let corners = corners.map(|corner| corner.map(|v| v as f32));
    let is_sound = (0..3).all(|a| (1e-6..1e6).contains(&(corners[1][a] - corners[0][a])));
    if is_sound { Ok(Some(corners)) } else { refuse("aabb", "a box of a size above 0") }
}

fn corners(aabb: &[Vec<f64>]) -> Option<[[f64; 3]; 2]> {
    let [min, max] = aabb else { return None };
    let (min, max) = (<[f64; 3]>::try_from(&min[..]).ok()?, <[f64; 3]>::try_from(&max[..]).ok()?);
    (0..3).all(|a| min[a] < max[a]).then_some([min, max])
}

fn three(value: &Value) -> Option<[f64; 3]> {
    match value {
        Value::Number(_) => value.as_f64().map(|v| [v; 3]),
        Value::Array(list) => {
            let list: Option<Vec<f64>> = list.iter().map(Value::as_f64).collect();
            <[f64; 3]>::try_from(&list?[..]).ok()
        }
        _ => None,
    }
}
