//! ngp_pl's checkpoints: networks and grid as tiny-cuda-nn keeps them.
//!
//! What its program sets once and for all is not in them: 16 levels of two features from 16
//! cells to 2048 a unit, one hidden layer of 64 for the density and two for the colour. The
//! size of the tables follows from the number of parameters.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use super::cells::{Cells, Order};
use super::grid::{Grid, Shape};
use super::tcnn::{Hashed, Widths, levels};
use super::{Parts, SceneContext};
use crate::Scene;
use crate::import::settings::setting;
use crate::import::tensors::{Tensors, values};
use crate::import::{Checkpoint, FieldError};

const PREFIXES: [&str; 3] = ["state_dict.model.", "model.", ""];
/// Features of the density network: all of its outputs.
const FEATURES: usize = 16;
/// Harmonics of the direction: degree 4.
const HARMONICS: usize = 16;
/// Cells of the finest level of a box of 2.
const FINEST: f32 = 2048.0;
/// What fully fused networks are padded to.
const ALIGNMENT: usize = 16;
/// Steps along the diagonal of the unit cube.
const STEPS: f32 = 1024.0;
/// Where its rays begin and end.
const NEAR: f32 = 0.01;
const MIN_TRANSMITTANCE: f32 = 1e-4;

pub(super) fn recognises(checkpoint: &Checkpoint<'_>) -> bool {
    PREFIXES.iter().any(|prefix| is_under(checkpoint, prefix))
}

fn is_under(checkpoint: &Checkpoint<'_>, prefix: &str) -> bool {
    let has = |name: &str| checkpoint.tensor(&format!("{prefix}{name}")).is_some();
    has("xyz_encoder.params") && has("rgb_net.params")
}

pub(super) fn read(checkpoint: &Checkpoint<'_>) -> Result<Parts, FieldError> {
    let prefix = PREFIXES.into_iter().find(|prefix| is_under(checkpoint, prefix));
    let tensors = prefix.and_then(|prefix| Tensors::of(checkpoint, prefix));
    let Some(mut tensors) = tensors else { return Err(FieldError::unknown(checkpoint)) };
    ["center", "half_size", "xyz_min", "density_grid", "grid_coords", "dir_encoder", "val_lpips"]
        .iter()
        .for_each(|name| tensors.ignore(name));

    let half = half(&tensors.numbers("xyz_max")?)?;
    let density = Widths { n_in: 32, hidden: 64, n_hidden: 1, n_out: FEATURES };
    let color = Widths { n_in: HARMONICS + FEATURES, hidden: 64, n_hidden: 2, n_out: 3 };
    let (name, params) = tensors.take("xyz_encoder.params")?;
    let color_params = tensors.numbers("rgb_net.params")?;
    if color_params.len() != color.len(ALIGNMENT) {
        let expected = color.len(ALIGNMENT).to_string();
        return Err(setting("rgb_net.params", &color_params.len().to_string(), &expected));
    }
    let shape = Shape {
        n_levels: 16,
        n_features: 2,
        base_resolution: 16,
        per_level_scale: ((FINEST * half / 16.0).ln() / 15.0).exp(),
        shift: 0.5,
    };
    let in_density = density.len(ALIGNMENT);
    let in_grid = params.len().checked_sub(in_density);
    let sized = (8..=24).find_map(|log2| {
        let levels = levels(&shape, Hashed::Beyond(1 << log2)).ok()?;
        let entries: usize = levels.iter().map(|level| level.entries as usize).sum();
        (in_grid == Some(2 * entries)).then_some(levels)
    });
    let Some(levels) = sized else {
        let expected = "networks and 16 levels of two features";
        return Err(setting(&name, &params.len().to_string(), expected));
    };
    let parts = params.part(0..in_density).zip(params.part(in_density..params.len()));
    let Some((networks, table)) = parts else { return Err(FieldError::unknown(checkpoint)) };
    let mut density = density.layers(&values(&*name, &networks)?, ALIGNMENT, 0.0);
    if let Some(last) = density.last_mut() {
        *last = last.first_output_twice();
    }
    let mut color = color.layers(&color_params, ALIGNMENT, 1.0);
    // It reads the harmonics, then the features.
    let rest = color.split_off(1);
    let first = color.into_iter().map(|layer| layer.last_inputs_first(FEATURES));
    let color = first.chain(rest).collect();
    let cells = tensors.bytes("density_bitfield")?.map(|bits| cells(half, &bits)).transpose()?;
    tensors.finish()?;
    Ok(Parts {
        program: "kwea123/ngp_pl",
        grid: Grid::new(shape, &levels, (&name, &table))?,
        density,
        color,
        sh_degree: 4,
        context: SceneContext {
            bounds: [[-half; 3], [half; 3]],
            crop: None,
            scene: Scene::default(),
            step: 3.0f32.sqrt() / STEPS,
            near: NEAR,
            min_transmittance: MIN_TRANSMITTANCE,
            background: None,
            cells,
            views: Vec::new(),
        },
    })
}

/// Half the box's side, which is a cube around the origin.
fn half(max: &[f32]) -> Result<f32, FieldError> {
    match max {
        &[x, y, z] if [y, z] == [x; 2] && (0.0625..=64.0).contains(&x) => Ok(x),
        other => Err(setting("xyz_max", &format!("{other:?}"), "one number three times")),
    }
}

/// Cubes whose sides are powers of two, none larger than the box.
fn cells(half: f32, bits: &[u8]) -> Result<Cells, FieldError> {
    let n_cubes = 1 + (2.0 * half).log2().ceil().max(0.0) as i32;
    let halves = (0..n_cubes).map(|i| 0.5 * (0.5 * 2.0f32.powi(i) / half).min(1.0)).collect();
    Cells::of_bits(Order::Morton, halves, bits).ok_or_else(|| {
        let expected = format!("a bit for each cell of {n_cubes} cubes");
        setting("density_bitfield", &format!("{} bytes", bits.len()), &expected)
    })
}
