//! A network of a checkpoint as core has it.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use pocketnerf_core::Error;
use pocketnerf_core::field::NerfNetwork;
use pocketnerf_core::network::{Dense, MAX_LAYERS, Mlp};

use crate::import::field_error::FieldError;
use crate::import::layer::{Layer, Stored};

/// The layers of a network by their roles, inputs in the order of the program.
pub(super) struct Parts {
    pub(super) trunk: Vec<Layer>,
    /// Bit i: no ReLU after layer i of the trunk.
    pub(super) linear: u16,
    /// Whether skip connections append the encoded point; else they put it first.
    pub(super) point_last: bool,
    pub(super) density: Layer,
    pub(super) feature: Option<Layer>,
    pub(super) feature_relu: bool,
    /// The first reads feature and direction.
    pub(super) color: Vec<Layer>,
}

impl Parts {
    pub(super) const fn new(trunk: Vec<Layer>, density: Layer, color: Vec<Layer>) -> Self {
        Self {
            trunk,
            linear: 0,
            point_last: false,
            density,
            feature: None,
            feature_relu: false,
            color,
        }
    }

    /// Colour and density are outputs of one layer, in this order; what follows counts
    /// for nothing.
    pub(super) fn without_directions(
        trunk: Vec<Layer>,
        output: &Layer,
        name: &str,
    ) -> Result<Self, FieldError> {
        if output.n_out < 4 {
            return Err(FieldError::Shape {
                name: name.to_string(),
                found: Vec::from([output.n_in, output.n_out]),
                expected: "at least 4 outputs".to_string(),
            });
        }
        Ok(Self::new(trunk, output.outputs(3..4), Vec::from([output.outputs(0..3)])))
    }
}

/// A network in memory of its own.
#[derive(Clone, Debug)]
pub(super) struct Network {
    trunk: Vec<Stored>,
    bits: [u16; 2],
    density: Stored,
    feature: Option<Stored>,
    feature_relu: bool,
    color: Vec<Stored>,
    /// Values that encode a position and a direction.
    pub(super) encoded: [usize; 2],
}

impl Network {
    /// Finds the skip connections by the layers' widths.
    pub(super) fn new(parts: Parts) -> Result<Self, FieldError> {
        let most = parts.trunk.len().max(parts.color.len());
        if most > MAX_LAYERS {
            return Err(FieldError::Layers(most));
        }
        let Some(first) = parts.trunk.first() else {
            return Err(FieldError::Missing("the first layer".to_string()));
        };
        let n_position = first.n_in;
        let (mut skips, mut width, mut trunk) = (0, 0, Vec::new());
        for (i, layer) in parts.trunk.into_iter().enumerate() {
            let n_out = layer.n_out;
            if i > 0 && layer.n_in == width + n_position {
                skips |= 1 << i;
                let first = if parts.point_last { n_position } else { 0 };
                trunk.push(layer.last_inputs_first(first).stored());
            } else {
                let expected = if i == 0 { n_position } else { width };
                expect(&format!("layer {i} of the trunk"), &layer, expected)?;
                trunk.push(layer.stored());
            }
            width = n_out;
        }
        expect("the density's layer", &parts.density, width)?;
        if let Some(feature) = &parts.feature {
            expect("the feature's layer", feature, width)?;
            width = feature.n_out;
        }
        let Some(first) = parts.color.first() else {
            return Err(FieldError::Missing("the colour's layers".to_string()));
        };
        let n_direction = first.n_in.saturating_sub(width);
        expect("the colour's first layer", first, width + n_direction)?;
        width = first.n_in;
        for (i, layer) in parts.color.iter().enumerate() {
            expect(&format!("layer {i} of the colour"), layer, width)?;
            width = layer.n_out;
        }
        Ok(Self {
            trunk,
            bits: [skips, parts.linear],
            density: parts.density.stored(),
            feature: parts.feature.as_ref().map(Layer::stored),
            feature_relu: parts.feature_relu,
            color: parts.color.iter().map(Layer::stored).collect(),
            encoded: [n_position, n_direction],
        })
    }

    /// For core.
    pub(super) fn view(&self) -> Result<NerfNetwork<'_>, Error> {
        let (trunk, color) = (views(&self.trunk)?, views(&self.color)?);
        let feature = self.feature.as_ref().map(Stored::view).transpose()?;
        let color = Mlp::new(&color[..self.color.len()])?;
        let trunk = &trunk[..self.trunk.len()];
        let mut network = NerfNetwork::new(trunk, self.bits, self.density.view()?, feature, color)?;
        network.feature_relu = self.feature_relu;
        Ok(network)
    }
}

fn views(layers: &[Stored]) -> Result<[Dense<'_>; MAX_LAYERS], Error> {
    let mut all = [Dense::EMPTY; MAX_LAYERS];
    // No more than there is room for, see `new`.
    for (to, layer) in all.iter_mut().zip(layers) {
        *to = layer.view()?;
    }
    Ok(all)
}

fn expect(name: &str, layer: &Layer, n_in: usize) -> Result<(), FieldError> {
    if layer.n_in == n_in {
        return Ok(());
    }
    Err(FieldError::Shape {
        name: name.to_string(),
        found: Vec::from([layer.n_in, layer.n_out]),
        expected: format!("{n_in} inputs"),
    })
}
