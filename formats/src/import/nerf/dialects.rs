//! How programs name the layers of a network, and what each does with them.

use std::format;
use std::string::String;
use std::vec::Vec;

use super::network::Parts;
use crate::import::field_error::FieldError;
use crate::import::layer::Layer;
use crate::import::tensors::Tensors;

/// The names that a program gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dialect {
    /// yenchenlin/nerf-pytorch, and most that descend from it.
    PtsLinears,
    /// krrish94/nerf-pytorch, the flexible model: no ReLU after the first layer, ReLU
    /// after the feature, skip connections that append.
    Flexible,
    /// krrish94/nerf-pytorch, the model of the paper's first version: the density is
    /// read from the feature, three layers follow the directions.
    FirstPaper,
    /// krrish94/nerf-pytorch, the model of the supplement: two layers, a feature, two
    /// layers.
    Replicate,
    /// kwea123/nerf_pl.
    XyzEncoding,
    /// bmild/nerf: pairs of kernel and bias without names.
    Pairs,
}

impl Dialect {
    /// By a name that only it gives.
    pub(super) fn of(tensors: &Tensors<'_, '_>) -> Option<Self> {
        let known = [
            ("pts_linears.0.weight", Self::PtsLinears),
            ("xyz_encoding_1.0.weight", Self::XyzEncoding),
            ("layer3.weight", Self::Replicate),
            ("layer1.weight", Self::Flexible),
            ("layers_xyz.0.weight", Self::FirstPaper),
            ("23", Self::Pairs),
            ("17", Self::Pairs),
        ];
        known.into_iter().find(|(name, _)| tensors.has(name)).map(|(_, dialect)| dialect)
    }

    /// The program, and the model where it has several.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::PtsLinears => "nerf-pytorch (yenchenlin)",
            Self::Flexible => "nerf-pytorch (krrish94, FlexibleNeRFModel)",
            Self::FirstPaper => "nerf-pytorch (krrish94, PaperNeRFModel)",
            Self::Replicate => "nerf-pytorch (krrish94, ReplicateNeRFModel)",
            Self::XyzEncoding => "nerf_pl",
            Self::Pairs => "nerf (bmild)",
        }
    }

    /// The layers of a network, and their roles.
    pub(super) fn parts(self, tensors: &mut Tensors<'_, '_>) -> Result<Parts, FieldError> {
        match self {
            Self::PtsLinears => pts_linears(tensors),
            Self::Flexible => flexible(tensors),
            Self::FirstPaper => first_paper(tensors),
            Self::Replicate => replicate(tensors),
            Self::XyzEncoding => xyz_encoding(tensors),
            Self::Pairs => pairs(tensors),
        }
    }
}

/// All layers whose names differ in their number.
fn all(
    tensors: &mut Tensors<'_, '_>,
    first: usize,
    name: impl Fn(usize) -> String,
) -> Result<Vec<Layer>, FieldError> {
    let count = tensors.count(first, &name);
    (first..first + count).map(|i| tensors.layer(&name(i))).collect()
}

fn pts_linears(tensors: &mut Tensors<'_, '_>) -> Result<Parts, FieldError> {
    let trunk = all(tensors, 0, |i| format!("pts_linears.{i}"))?;
    if tensors.has("output_linear.weight") {
        // Made and saved whether directions count or not.
        tensors.ignore("views_linears.");
        return Parts::without_directions(trunk, &tensors.layer("output_linear")?, "output_linear");
    }
    let density = tensors.layer("alpha_linear")?;
    let feature = Some(tensors.layer("feature_linear")?);
    let mut color = all(tensors, 0, |i| format!("views_linears.{i}"))?;
    color.push(tensors.layer("rgb_linear")?);
    Ok(Parts { feature, ..Parts::new(trunk, density, color) })
}

fn flexible(tensors: &mut Tensors<'_, '_>) -> Result<Parts, FieldError> {
    let mut trunk = Vec::from([tensors.layer("layer1")?]);
    trunk.append(&mut all(tensors, 0, |i| format!("layers_xyz.{i}"))?);
    let parts = if tensors.has("fc_out.weight") {
        Parts::without_directions(trunk, &tensors.layer("fc_out")?, "fc_out")?
    } else {
        let density = tensors.layer("fc_alpha")?;
        let feature = Some(tensors.layer("fc_feat")?);
        let mut color = all(tensors, 0, |i| format!("layers_dir.{i}"))?;
        color.push(tensors.layer("fc_rgb")?);
        Parts { feature, feature_relu: true, ..Parts::new(trunk, density, color) }
    };
    Ok(Parts { linear: 1, point_last: true, ..parts })
}

fn first_paper(tensors: &mut Tensors<'_, '_>) -> Result<Parts, FieldError> {
    let mut trunk = all(tensors, 0, |i| format!("layers_xyz.{i}"))?;
    // Everything is read from the feature: it is the trunk's last layer.
    let linear = 1u16.checked_shl(trunk.len() as u32).unwrap_or(0);
    trunk.push(tensors.layer("fc_feat")?);
    let density = tensors.layer("fc_alpha")?;
    // Four are saved, three are used.
    let mut color = all(tensors, 0, |i| format!("layers_dir.{i}"))?;
    color.truncate(3);
    color.push(tensors.layer("fc_rgb")?);
    Ok(Parts { linear, ..Parts::new(trunk, density, color) })
}

fn replicate(tensors: &mut Tensors<'_, '_>) -> Result<Parts, FieldError> {
    let trunk = Vec::from([tensors.layer("layer1")?, tensors.layer("layer2")?]);
    let feature = Some(tensors.layer("layer3")?);
    let density = tensors.layer("fc_alpha")?;
    let color = [tensors.layer("layer4")?, tensors.layer("layer5")?, tensors.layer("fc_rgb")?];
    Ok(Parts { feature, ..Parts::new(trunk, density, Vec::from(color)) })
}

fn xyz_encoding(tensors: &mut Tensors<'_, '_>) -> Result<Parts, FieldError> {
    let trunk = all(tensors, 1, |i| format!("xyz_encoding_{i}.0"))?;
    let feature = Some(tensors.layer("xyz_encoding_final")?);
    let density = tensors.layer("sigma")?;
    let color = [tensors.layer("dir_encoding.0")?, tensors.layer("rgb.0")?];
    Ok(Parts { feature, ..Parts::new(trunk, density, Vec::from(color)) })
}

/// Kernels `[n_in, n_out]` and biases in turn: the trunk, then feature, directions, colour
/// and density, or one layer of all four outputs.
fn pairs(tensors: &mut Tensors<'_, '_>) -> Result<Parts, FieldError> {
    let mut layers = Vec::new();
    while tensors.has(&format!("{}", 2 * layers.len())) {
        let i = 2 * layers.len();
        layers.push(tensors.pair(&format!("{i}"), &format!("{}", i + 1))?);
    }
    let last = layers.pop().ok_or_else(|| FieldError::Missing("0".into()))?;
    if last.n_out != 1 {
        return Parts::without_directions(layers, &last, "the last kernel");
    }
    let missing = || FieldError::Missing("feature, directions and colour".into());
    let heads = layers.len().checked_sub(3).ok_or_else(missing)?;
    let mut color = layers.split_off(heads);
    let feature = Some(color.remove(0));
    Ok(Parts { feature, ..Parts::new(layers, last, color) })
}
