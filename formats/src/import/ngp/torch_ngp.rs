//! torch-ngp's checkpoints, `nerf/network.py` with its own encoder.
//!
//! The grid reaches from -bound to bound, with 16 cells at first and 2048 bound at last; the
//! stored offsets have to agree. A dense level has a corner more along an axis than
//! tiny-cuda-nn's, unless its corners are aligned with the box's.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use pocketnerf_core::encoding::CornerLevel;

use super::cells::{Cells, Order};
use super::grid::{Grid, Shape};
use super::{Parts, SceneContext};
use crate::Scene;
use crate::import::settings::setting;
use crate::import::tensors::Tensors;
use crate::import::{Checkpoint, FieldError};

const PREFIXES: [&str; 2] = ["model.", ""];
/// Cells of the coarsest level along the box, and of the finest along a unit.
const COARSEST: u32 = 16;
const FINEST: u32 = 2048;
/// Steps along the diagonal of a box from -1 to 1.
const STEPS: f32 = 1024.0;
/// Defaults of its options `--min_near` and `T_thresh`.
const NEAR: f32 = 0.2;
const MIN_TRANSMITTANCE: f32 = 1e-4;
/// Harmonics of the direction: degree 4.
const HARMONICS: usize = 16;

pub(super) fn recognises(checkpoint: &Checkpoint<'_>) -> bool {
    PREFIXES.iter().any(|prefix| is_under(checkpoint, prefix))
}

fn is_under(checkpoint: &Checkpoint<'_>, prefix: &str) -> bool {
    checkpoint.tensor(&format!("{prefix}encoder.embeddings")).is_some()
}

pub(super) fn read(checkpoint: &Checkpoint<'_>) -> Result<Parts, FieldError> {
    let prefix = PREFIXES.into_iter().find(|prefix| is_under(checkpoint, prefix));
    let tensors = prefix.and_then(|prefix| Tensors::of(checkpoint, prefix));
    let Some(mut tensors) = tensors else { return Err(FieldError::unknown(checkpoint)) };
    ["step_counter", "aabb_infer", "density_grid", "mean_density", "mean_count"]
        .iter()
        .for_each(|name| tensors.ignore(name));

    let bound = bound(&tensors.numbers("aabb_train")?)?;
    let offsets = tensors.numbers("encoder.offsets")?;
    let (name, table) = tensors.take("encoder.embeddings")?;
    let &[_, n_features] = table.shape() else { return Err(FieldError::unknown(checkpoint)) };
    let (shape, levels) = levels(&offsets, n_features, bound)?;
    let mut density = Vec::new();
    for i in 0..tensors.count(0, |i| format!("sigma_net.{i}")) {
        density.push(tensors.unbiased(&format!("sigma_net.{i}"))?);
    }
    let mut color = Vec::new();
    for i in 0..tensors.count(0, |i| format!("color_net.{i}")) {
        let layer = tensors.unbiased(&format!("color_net.{i}"))?;
        // It reads the harmonics, then the features.
        let n_features = layer.n_in.saturating_sub(HARMONICS);
        color.push(if i == 0 { layer.last_inputs_first(n_features) } else { layer });
    }
    let order = match tensors.shape("density_grid") {
        Some([_, _, _, _]) => Order::LastFirst,
        _ => Order::Morton,
    };
    let bits = tensors.bytes("density_bitfield")?;
    let cells = bits.map(|bits| cells(order, bound, &bits)).transpose()?;
    tensors.finish()?;
    Ok(Parts {
        program: "ashawkey/torch-ngp",
        grid: Grid::new(shape, &levels, (&name, table))?,
        density,
        color,
        sh_degree: 4,
        context: SceneContext {
            bounds: [[-bound; 3], [bound; 3]],
            crop: None,
            scene: Scene::default(),
            step: 2.0 * 3.0f32.sqrt() / STEPS,
            near: NEAR,
            min_transmittance: MIN_TRANSMITTANCE,
            background: None,
            cells,
            views: Vec::new(),
        },
    })
}

/// Half the box's side.
fn bound(aabb: &[f32]) -> Result<f32, FieldError> {
    match aabb {
        &[a, b, c, x, y, z] if [-a, -b, -c, x, y, z] == [x; 6] && (0.125..=128.0).contains(&x) => {
            Ok(x)
        }
        other => Err(setting("aabb_train", &format!("{other:?}"), "a cube around the origin")),
    }
}

/// Levels of the sizes that `offsets` leave for them.
fn levels(
    offsets: &[f32],
    n_features: usize,
    bound: f32,
) -> Result<(Shape, Vec<CornerLevel>), FieldError> {
    let n_levels = offsets.len().saturating_sub(1);
    if !(1..=16).contains(&n_levels) {
        return Err(setting("encoder.offsets", &offsets.len().to_string(), "2 to 17 of them"));
    }
    // Growth in f64, what the kernel makes of it in f32.
    let finest = f64::from(FINEST) * f64::from(bound);
    let log2 = (finest / f64::from(COARSEST)).log2() / (n_levels.max(2) - 1) as f64;
    let sizes = offsets.windows(2).map(|pair| (pair[1] - pair[0]) as u32);
    let aligned = sizes.clone().next() == Some(COARSEST.pow(3))
        && sizes.clone().max() > Some(COARSEST.pow(3));
    let mut levels = Vec::new();
    for (l, entries) in sizes.enumerate() {
        let scale = (l as f32 * log2 as f32).exp2() * COARSEST as f32 - 1.0;
        let side = scale.ceil() as u64 + 1 + u64::from(!aligned);
        let corners = side.pow(3);
        let level = match u64::from(entries) {
            // The first version did not round up to eights.
            n if corners <= n && n < corners + 8 => {
                CornerLevel { scale, side: side as u32, entries }
            }
            n if n < corners && entries.is_power_of_two() => {
                CornerLevel { scale, side: 0, entries }
            }
            _ => {
                let expected =
                    format!("{corners} or a power of two: 16 cells at first, {finest} at last");
                let name = format!("encoder.offsets, entries of level {l}");
                return Err(setting(&name, &entries.to_string(), &expected));
            }
        };
        levels.push(level);
    }
    let shape = Shape {
        n_levels: n_levels as u32,
        n_features: n_features as u32,
        base_resolution: COARSEST,
        per_level_scale: log2.exp2() as f32,
        shift: if aligned { 0.0 } else { 0.5 },
    };
    Ok((shape, levels))
}

/// Cubes from -2^i to 2^i, none larger than the box.
fn cells(order: Order, bound: f32, bits: &[u8]) -> Result<Cells, FieldError> {
    let n_cubes = 1 + bound.log2().ceil().max(0.0) as i32;
    let halves = (0..n_cubes).map(|i| 0.5 * (2.0f32.powi(i) / bound).min(1.0)).collect();
    Cells::of_bits(order, halves, bits).ok_or_else(|| {
        let expected = format!("a bit for each cell of {n_cubes} cubes");
        setting("density_bitfield", &format!("{} bytes", bits.len()), &expected)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_by_their_sizes() {
        // Two levels of 16 and 2048 cells in a box of bound 1, tables of 2^13.
        let of = |sizes: &[f32]| {
            let offsets: Vec<f32> = core::iter::once(0.0)
                .chain(sizes.iter().scan(0.0, |sum, size| {
                    *sum += size;
                    Some(*sum)
                }))
                .collect();
            levels(&offsets, 2, 1.0)
        };
        // 17 corners a side, rounded up to eights or, at first, not; 16 where they are
        // aligned with the box's.
        for (entries, side, shift) in [(4920, 17, 0.5), (4913, 17, 0.5), (4096, 16, 0.0)] {
            let (shape, found) = of(&[entries as f32, 8192.0]).unwrap();
            let first = CornerLevel { scale: 15.0, side, entries };
            assert_eq!((shape.shift, found[0], found[1].side), (shift, first, 0));
            assert_eq!((found[1].scale, found[1].entries), (2047.0, 8192));
        }
        // Another resolution at first.
        let error = of(&[1000.0, 8192.0]).unwrap_err().to_string();
        assert!(error.contains("entries of level 0") && error.contains("4913"), "{error}");
        assert!(levels(&[0.0], 2, 1.0).is_err());
    }

    #[test]
    fn boxes() {
        assert_eq!(bound(&[-2.0, -2.0, -2.0, 2.0, 2.0, 2.0]), Ok(2.0));
        assert!(bound(&[-2.0, -1.0, -2.0, 2.0, 1.0, 2.0]).is_err());
        assert!(bound(&[f32::NAN; 6]).is_err() && bound(&[]).is_err());
    }
}
