//! instant-ngp's snapshots: its configuration, and under `snapshot` what was learnt.
//!
//! `params_binary` holds the density network, the colour network and the grid. Positions
//! are relative to the box; matrices have no biases.

use std::format;
use std::string::ToString;

use pocketnerf_core::Camera;

use super::cells::{Cells, Order};
use super::grid::Grid;
use super::tcnn::{self, Widths};
use super::{Parts, SceneContext};
use crate::import::settings::{Settings, setting};
use crate::import::tensors::values;
use crate::import::{Checkpoint, ElementType, FieldError, Tensor};
use crate::{MAX_PICTURE_SIDE, Scene};

const PARAMS: &str = "snapshot.params_binary";
/// Cells of the finest level along a unit, where the configuration has no growth.
const FINEST: f32 = 2048.0;
/// Outputs of the density network: all of them are features, the first is the logarithm of
/// the density as well.
const FEATURES: usize = 16;
/// Harmonics of the direction: degree 4.
const HARMONICS: usize = 16;
/// A cell is looked at where a step through it has at least this optical thickness, or the
/// mean of all cells.
const THICKNESS: f32 = 0.01;
/// Steps along the diagonal of the unit cube.
const STEPS: f32 = 1024.0;
/// Where its pictures begin.
const NEAR: f32 = 0.05;
/// Where its rays end.
const MIN_TRANSMITTANCE: f32 = 0.01;
/// Most cameras that are taken over.
const MAX_VIEWS: usize = 10_000;

pub(super) fn recognises(checkpoint: &Checkpoint<'_>) -> bool {
    checkpoint.tensor(PARAMS).is_some()
}

pub(super) fn read(checkpoint: &Checkpoint<'_>) -> Result<Parts, FieldError> {
    let settings = Settings(checkpoint);
    settings.choice("snapshot.mode", "nerf", &["nerf"])?;
    settings.count("snapshot.version", 1, 0..=1)?;
    settings.count("snapshot.nerf.dataset.n_extra_learnable_dims", 0, 0..=0)?;
    let hdr = "snapshot.nerf.dataset.is_hdr";
    if settings.0.number(hdr).is_some_and(|hdr| hdr != 0.0) {
        return Err(setting(hdr, "true", "colours between 0 and 1"));
    }
    let aabb_scale = aabb_scale(settings)?;
    let (shape, hashed) = tcnn::grid(settings, "encoding", FINEST * aabb_scale as f32)?;
    let levels = tcnn::levels(&shape, hashed)?;
    let params = params(settings)?;

    let density =
        widths(settings, "network", [(shape.n_levels * shape.n_features) as usize, FEATURES])?;
    let color = widths(settings, "rgb_network", [FEATURES + harmonics(settings)?, 3])?;
    let in_grid: usize = levels.iter().map(|level| level.entries as usize).sum();
    let in_grid = in_grid * shape.n_features as usize;
    let alignments = [16, 8].iter().flat_map(|a| [[*a, 16], [*a, 8]]);
    let len = |&[a, b]: &[usize; 2]| density.len(a) + color.len(b) + in_grid;
    let Some(alignment) = alignments.clone().find(|both| len(both) == params.len()) else {
        let expected = format!("{} for this configuration", len(&[16, 16]));
        return Err(setting(PARAMS, &params.len().to_string(), &expected));
    };
    let in_networks = params.len() - in_grid;
    let parts = params.part(0..in_networks).zip(params.part(in_networks..params.len()));
    let Some((networks, table)) = parts else { return Err(FieldError::unknown(checkpoint)) };
    let networks = values(PARAMS, &networks)?;
    let (density_params, color_params) = networks.split_at(density.len(alignment[0]));

    // A grid pads with zeros; the colour network's inputs are as many as it takes.
    let mut density = density.layers(density_params, alignment[0], 0.0);
    if let Some(last) = density.last_mut() {
        // The density is a feature too.
        *last = last.first_output_twice();
    }
    Ok(Parts {
        program: "NVlabs/instant-ngp",
        grid: Grid::new(shape, &levels, (PARAMS, &table))?,
        density,
        color: color.layers(color_params, alignment[1], 0.0),
        sh_degree: 4,
        context: context(settings, aabb_scale)?,
    })
}

/// Sides of the box, unit cubes.
fn aabb_scale(settings: Settings<'_, '_>) -> Result<u32, FieldError> {
    let outer = settings.count("snapshot.nerf.aabb_scale", 1, 1..=128)?;
    let scale = settings.count("snapshot.nerf.dataset.aabb_scale", outer, 1..=128)?;
    match scale.is_power_of_two() {
        true => Ok(scale),
        false => Err(setting("aabb_scale", &scale.to_string(), "a power of two")),
    }
}

/// All parameters. Their number tells what they are where their type does not.
fn params<'a>(settings: Settings<'_, 'a>) -> Result<Tensor<'a>, FieldError> {
    let bytes = settings.tensor(PARAMS)?;
    let expected = settings.number("snapshot.n_params")?;
    let floats = expected * 4.0 == bytes.len() as f64;
    let default = if floats { "float" } else { "__half" };
    let element = match settings.choice("snapshot.params_type", default, &["__half", "float"])? {
        "float" => ElementType::F32,
        _ => ElementType::F16,
    };
    let params = bytes.reinterpreted(element).ok_or_else(|| {
        setting(PARAMS, &format!("{} bytes", bytes.len()), &format!("values of {element}"))
    })?;
    if expected != params.len() as f64 {
        return Err(setting("snapshot.n_params", &expected.to_string(), &params.len().to_string()));
    }
    Ok(params)
}

/// The widths of a network, of its inputs and outputs.
fn widths(
    settings: Settings<'_, '_>,
    name: &str,
    [n_in, n_out]: [usize; 2],
) -> Result<Widths, FieldError> {
    let key = |key: &str| format!("{name}.{key}");
    let otypes = ["FullyFusedMLP", "CutlassMLP", "MegakernelMLP"];
    settings.choice(&key("otype"), "CutlassMLP", &otypes)?;
    settings.choice(&key("activation"), "ReLU", &["ReLU"])?;
    settings.choice(&key("output_activation"), "None", &["None"])?;
    settings.count(&key("n_output_dims"), n_out as u32, n_out as u32..=n_out as u32)?;
    let hidden = settings.count(&key("n_neurons"), 128, 1..=1024)?;
    let n_hidden = settings.count(&key("n_hidden_layers"), 5, 1..=9)?;
    Ok(Widths { n_in, hidden: hidden as usize, n_hidden: n_hidden as usize, n_out })
}

/// Values that encode a direction.
fn harmonics(settings: Settings<'_, '_>) -> Result<usize, FieldError> {
    let otype = settings.0.text("dir_encoding.otype").unwrap_or_default();
    let name = match otype.eq_ignore_ascii_case("Composite") {
        true => "dir_encoding.nested.0",
        false => "dir_encoding",
    };
    settings.choice(&format!("{name}.otype"), "", &["SphericalHarmonics"])?;
    settings.count(&format!("{name}.degree"), 4, 4..=4)?;
    Ok(HARMONICS)
}

fn context(settings: Settings<'_, '_>, aabb_scale: u32) -> Result<SceneContext, FieldError> {
    let half = 0.5 * aabb_scale as f32;
    let bounds = [[0.5 - half; 3], [0.5 + half; 3]];
    if let Some(found) = corners(settings, "snapshot.aabb")
        && found != bounds
    {
        return Err(setting("snapshot.aabb", &format!("{found:?}"), &format!("{bounds:?}")));
    }
    let crop = corners(settings, "snapshot.render_aabb").filter(|[min, max]| {
        let inside = |a: usize| min[a] > bounds[0][a] || max[a] < bounds[1][a];
        (0..3).any(inside) && (0..3).all(|a| min[a] < max[a])
    });
    let background = settings.vector::<4>("snapshot.background_color");
    Ok(SceneContext {
        bounds,
        crop,
        scene: scene(settings)?,
        step: 3.0f32.sqrt() / STEPS,
        near: NEAR,
        min_transmittance: MIN_TRANSMITTANCE,
        background: background.map(|[r, g, b, _]| [r, g, b]),
        cells: cells(settings, aabb_scale)?,
        views: (0..MAX_VIEWS).map_while(|i| view(settings, i)).collect(),
    })
}

fn corners(settings: Settings<'_, '_>, name: &str) -> Option<[[f32; 3]; 2]> {
    Some([settings.vector(&format!("{name}.min"))?, settings.vector(&format!("{name}.max"))?])
}

/// A point p of the dataset is `p scale + offset` with its axes in turn: y, z, x.
fn scene(settings: Settings<'_, '_>) -> Result<Scene<'static>, FieldError> {
    let dataset = "snapshot.nerf.dataset";
    let scale = settings.0.number(&format!("{dataset}.scale")).unwrap_or(0.33) as f32;
    let offset = settings.vector(&format!("{dataset}.offset")).unwrap_or([0.5; 3]);
    let scales = 1e-6..1e6;
    if !scales.contains(&scale) {
        return Err(setting(&format!("{dataset}.scale"), &scale.to_string(), "1e-6 to 1e6"));
    }
    let mitsuba = settings.0.number(&format!("{dataset}.from_mitsuba"));
    let rotation = match mitsuba.is_some_and(|mitsuba| mitsuba != 0.0) {
        true => Scene::default().rotation,
        false => [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    let translation = offset.map(|offset| -offset / scale);
    Ok(Scene { scale: 1.0 / scale, rotation, translation, name: None })
}

/// Densities times the shortest step, f16, of cubes around the unit cube.
fn cells(settings: Settings<'_, '_>, aabb_scale: u32) -> Result<Option<Cells>, FieldError> {
    let name = "snapshot.density_grid_binary";
    let bytes = settings.0.tensor(name).filter(|bytes| !bytes.is_empty());
    let Some(bytes) = bytes else { return Ok(None) };
    let side = settings.count("snapshot.density_grid_size", 128, 1..=128)? as usize;
    let n_cubes = aabb_scale.ilog2() as usize + 1;
    let cells = side.pow(3);
    let expected = format!("{n_cubes} cubes of {side} cells a side, f16");
    if !side.is_power_of_two() || bytes.len() != 2 * n_cubes * cells {
        return Err(setting(name, &format!("{} bytes", bytes.len()), &expected));
    }
    let Some(densities) = bytes.reinterpreted(ElementType::F16) else { return Ok(None) };
    let densities = values(name, &densities)?;
    // Cells that no camera has seen are less than zero.
    let smallest = densities[..cells].iter().map(|density| f64::from(density.max(0.0)));
    let mean = smallest.sum::<f64>() / cells as f64;
    let threshold = THICKNESS.min(mean as f32);
    let is_occupied = |cube: usize, cell: usize| densities[cube * cells + cell] > threshold;
    let halves = (0..n_cubes).map(|i| (1 << i) as f32 * 0.5 / aabb_scale as f32).collect();
    Ok(Some(Cells::new(side, Order::Morton, halves, is_occupied)))
}

/// A training camera: its columns are right, down, forwards and where it stands.
fn view(settings: Settings<'_, '_>, i: usize) -> Option<Camera> {
    let dataset = "snapshot.nerf.dataset";
    let row = |r: usize| -> Option<[f32; 4]> {
        // Earlier versions have one pose, later ones two for a rolling shutter.
        let pose = format!("{dataset}.xforms.{i}");
        let of = |name: &str| settings.vector(&format!("{pose}{name}.{r}"));
        of(".start").or_else(|| of(""))
    };
    let rows = [row(0)?, row(1)?, row(2)?].map(|[x, y, z, t]| [x, -y, -z, t]);
    let metadata = format!("{dataset}.metadata.{i}");
    let size = settings.vector::<2>(&format!("{metadata}.resolution"))?;
    let focal = settings.vector::<2>(&format!("{metadata}.focal_length"))?;
    let center = settings.vector::<2>(&format!("{metadata}.principal_point"))?;
    // A model file holds no larger pictures than these.
    let sides = 1.0..=MAX_PICTURE_SIDE as f32;
    if !size.iter().all(|side| sides.contains(side))
        || !focal.iter().all(|f| (1.0..1e6).contains(f))
    {
        return None;
    }
    let mut camera_to_world = [0.0; 16];
    camera_to_world[..12].copy_from_slice(rows.as_flattened());
    camera_to_world[15] = 1.0;
    Some(Camera {
        width: size[0] as u32,
        height: size[1] as u32,
        focal,
        center: [0, 1].map(|a| center[a] * size[a]),
        camera_to_world,
    })
}
