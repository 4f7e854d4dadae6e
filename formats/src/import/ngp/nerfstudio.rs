//! nerfstudio's instant-ngp in a box: by tiny-cuda-nn or in torch, which are two fields.
//!
//! In torch every level is hashed, positions have no shift, layers have biases, and the
//! harmonics are evaluated at (d + 1) / 2. The result is a polynomial of degree three in d,
//! hence a sum of its harmonics, which the first layer absorbs.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use pocketnerf_core::encoding::CornerLevel;

use super::cells::{Cells, Order};
use super::grid::{Grid, Shape};
use super::harmonics::{HARMONICS, of_half_directions};
use super::tcnn::{Hashed, Widths, levels};
use super::{Parts, SceneContext};
use crate::Scene;
use crate::import::layer::Layer;
use crate::import::settings::setting;
use crate::import::tensors::{Tensors, values};
use crate::import::{Checkpoint, FieldError};

const PREFIX: &str = "pipeline._model.field.";
const TCNN: &str = "mlp_base.model.params";
const TORCH: &str = "mlp_base.model.0.hash_table";
/// Outputs of the density network: the logarithm of the density, then features.
const OUTPUTS: usize = 16;
/// Cells of the coarsest level.
const COARSEST: u32 = 16;
/// Features of a level.
const FEATURES: u32 = 2;
/// What fully fused networks are padded to.
const ALIGNMENT: usize = 16;
/// Default number of steps along the diagonal of the box.
const STEPS: f32 = 1000.0;
/// Where its rays begin by default, and where they end.
const NEAR: f32 = 0.01;
const MIN_TRANSMITTANCE: f32 = 1e-4;

pub(super) fn recognises(checkpoint: &Checkpoint<'_>) -> bool {
    [TCNN, TORCH].iter().any(|name| checkpoint.tensor(&format!("{PREFIX}{name}")).is_some())
}

pub(super) fn read(checkpoint: &Checkpoint<'_>) -> Result<Parts, FieldError> {
    if let Some(name) = checkpoint.names().find(|name| name.contains("proposal_networks.")) {
        let expected = "instant-ngp: where nerfacto's samples lie, and the contracted space they \
                        lie in, cannot be expressed";
        return Err(setting(name, "nerfacto", expected));
    }
    let Some(mut tensors) = Tensors::of(checkpoint, PREFIX) else {
        return Err(FieldError::unknown(checkpoint));
    };
    ["direction_encoding.", "position_encoding."].iter().for_each(|name| tensors.ignore(name));
    let bounds = bounds(&tensors.numbers("aabb")?)?;
    let sizes = Sizes {
        n_levels: tensors.count_of("num_levels", 1..=16)?,
        log2: tensors.count_of("log2_hashmap_size", 3..=24)?,
        finest: tensors.count_of("max_res", COARSEST..=1 << 20)?,
    };
    let (grid, density, color) =
        if tensors.has(TCNN) { tcnn(&mut tensors, &sizes)? } else { torch(&mut tensors, &sizes)? };
    tensors.finish()?;
    let [min, max] = bounds;
    Ok(Parts {
        program: "nerfstudio",
        grid,
        density,
        color,
        sh_degree: 4,
        context: SceneContext {
            bounds,
            crop: None,
            scene: Scene::default(),
            step: 3.0f32.sqrt() * (max[0] - min[0]) / STEPS,
            near: NEAR,
            min_transmittance: MIN_TRANSMITTANCE,
            background: None,
            cells: cells(checkpoint)?,
            views: Vec::new(),
        },
    })
}

struct Sizes {
    n_levels: u32,
    log2: u32,
    finest: u32,
}

impl Sizes {
    /// Growth from level to level.
    fn growth(&self) -> f64 {
        let ratio = f64::from(self.finest).ln() - f64::from(COARSEST).ln();
        (ratio / f64::from(self.n_levels.max(2) - 1)).exp()
    }

    fn shape(&self, shift: f32) -> Shape {
        Shape {
            n_levels: self.n_levels,
            n_features: FEATURES,
            base_resolution: COARSEST,
            per_level_scale: self.growth() as f32,
            shift,
        }
    }

    fn n_encoded(&self) -> usize {
        (self.n_levels * FEATURES) as usize
    }
}

/// Grid, density network and colour network.
type Field = (Grid, Vec<Layer>, Vec<Layer>);

fn tcnn(tensors: &mut Tensors<'_, '_>, sizes: &Sizes) -> Result<Field, FieldError> {
    let shape = sizes.shape(0.5);
    let levels = levels(&shape, Hashed::Beyond(1 << sizes.log2))?;
    let entries: usize = levels.iter().map(|level| level.entries as usize).sum();
    let (name, params) = tensors.take(TCNN)?;
    let in_density = params.len().saturating_sub(entries * FEATURES as usize);
    let density = Widths { n_in: sizes.n_encoded(), hidden: 0, n_hidden: 1, n_out: OUTPUTS };
    let density = density.of_len(in_density, ALIGNMENT);
    let density = density.ok_or_else(|| {
        let expected = format!("a hidden layer, then {entries} entries");
        setting(&name, &params.len().to_string(), &expected)
    })?;
    let refuse = || setting(&name, &params.len().to_string(), "a list of parameters");
    let table = params.part(in_density..params.len()).ok_or_else(refuse)?;
    let networks = params.part(0..in_density).ok_or_else(refuse)?;
    let density = density.layers(&values(&*name, &networks)?, ALIGNMENT, 0.0);
    let grid = Grid::new(shape, &levels, (&name, &table))?;

    let name = "mlp_head.tcnn_encoding.params";
    let params = tensors.numbers(name)?;
    let features = OUTPUTS - 1;
    let color = Widths { n_in: HARMONICS + features, hidden: 0, n_hidden: 2, n_out: 3 };
    let color = color.of_len(params.len(), ALIGNMENT).ok_or_else(|| {
        let expected = "two hidden layers behind harmonics and features (no appearance)";
        setting(name, &params.len().to_string(), expected)
    })?;
    // A network alone is padded with ones, other than a grid.
    let mut color = color.layers(&params, ALIGNMENT, 1.0);
    features_first(&mut color, features);
    Ok((grid, density, color))
}

fn torch(tensors: &mut Tensors<'_, '_>, sizes: &Sizes) -> Result<Field, FieldError> {
    let growth = sizes.growth() as f32;
    let level = |l: u32| {
        // In f32, as there: the last of 2048 cells is one of 2047.
        let scale = (COARSEST as f32 * growth.powf(l as f32)).floor();
        CornerLevel { scale, side: 0, entries: 1 << sizes.log2 }
    };
    let levels: Vec<CornerLevel> = (0..sizes.n_levels).map(level).collect();
    let (name, table) = tensors.take(TORCH)?;
    if !matches!(table.shape(), [_, features] if *features == FEATURES as usize) {
        return Err(setting(&name, &format!("{:?}", table.shape()), "two features an entry"));
    }
    let layers = |tensors: &mut Tensors<'_, '_>, name: &str| {
        let names = |i: usize| format!("{name}.layers.{i}");
        (0..tensors.count(0, names))
            .map(|i| tensors.layer(&names(i)))
            .collect::<Result<Vec<_>, _>>()
    };
    let density = layers(tensors, "mlp_base.model.1")?;
    let mut color = layers(tensors, "mlp_head")?;
    let n_features = density.last().map_or(0, |layer| layer.n_out.saturating_sub(1));
    if let Some(first) = color.first_mut() {
        let expected = HARMONICS + n_features;
        if first.n_in != expected {
            let found = format!("{} inputs", first.n_in);
            let expected = format!("{expected}: harmonics and features (no appearance)");
            return Err(setting("mlp_head.layers.0.weight", &found, &expected));
        }
        *first = first.with_first_inputs(&of_half_directions());
    }
    features_first(&mut color, n_features);
    Ok((Grid::new(sizes.shape(0.0), &levels, (&name, table))?, density, color))
}

/// It reads the harmonics, then the features.
fn features_first(color: &mut [Layer], n_features: usize) {
    if let Some(first) = color.first_mut() {
        *first = first.clone().last_inputs_first(n_features);
    }
}

fn bounds(aabb: &[f32]) -> Result<[[f32; 3]; 2], FieldError> {
    let refuse = || setting("aabb", &format!("{aabb:?}"), "a box that is a cube");
    let &[a, b, c, x, y, z] = aabb else { return Err(refuse()) };
    let sides = [x - a, y - b, z - c];
    let is_cube = sides.iter().all(|side| (side - sides[0]).abs() <= 1e-5 * sides[0]);
    if is_cube && sides[0] > 0.0 { Ok([[a, b, c], [x, y, z]]) } else { Err(refuse()) }
}

/// nerfacc's cells of the box; those of boxes around it see nothing.
fn cells(checkpoint: &Checkpoint<'_>) -> Result<Option<Cells>, FieldError> {
    let name = "pipeline._model.occupancy_grid.binaries";
    let older = "pipeline._model.occupancy_grid._binary";
    let found = [name, older].into_iter().find_map(|name| Some((name, checkpoint.tensor(name)?)));
    let Some((name, tensor)) = found else { return Ok(None) };
    let side = match *tensor.shape() {
        [_, x, y, z] | [x, y, z] if x == y && y == z && (1..=512).contains(&x) => x,
        _ => {
            let (name, found) = (name.to_string(), tensor.shape().to_vec());
            let expected = "as many cells along every axis, at most 512".to_string();
            return Err(FieldError::Shape { name, found, expected });
        }
    };
    let bytes = tensor.to_bytes().map_err(|error| FieldError::Tensor(name.to_string(), error))?;
    if bytes.len() < side * side * side {
        return Ok(None);
    }
    let is_occupied = |_, cell: usize| bytes[cell] != 0;
    Ok(Some(Cells::new(side, Order::LastFirst, Vec::from([0.5]), is_occupied)))
}
