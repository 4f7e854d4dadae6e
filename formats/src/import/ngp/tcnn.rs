//! What tiny-cuda-nn keeps in one list of parameters: matrices without biases, row after
//! row `[n_out, n_in]`, and the entries of a grid.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use pocketnerf_core::encoding::CornerLevel;

use super::grid::Shape;
use crate::import::FieldError;
use crate::import::layer::Layer;
use crate::import::settings::{Settings, setting};

/// The widths of a network without those that padding adds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Widths {
    pub(super) n_in: usize,
    pub(super) hidden: usize,
    pub(super) n_hidden: usize,
    pub(super) n_out: usize,
}

impl Widths {
    /// Parameters where inputs and outputs are padded to a multiple of `alignment`.
    pub(super) const fn len(&self, alignment: usize) -> usize {
        let ends = self.n_in.next_multiple_of(alignment) + self.n_out.next_multiple_of(alignment);
        self.hidden * (ends + (self.n_hidden - 1) * self.hidden)
    }

    /// The same with hidden layers of the width that makes it so long, where there is one.
    pub(super) fn of_len(&self, len: usize, alignment: usize) -> Option<Self> {
        let mut widths = [16, 32, 64, 128, 256].into_iter().map(|hidden| Self { hidden, ..*self });
        widths.find(|widths| widths.len(alignment) == len)
    }

    /// The layers, from the front of `values`, which are as many as [`Self::len`]. Inputs
    /// that padding adds hold `padding`.
    pub(super) fn layers(&self, mut values: &[f32], alignment: usize, padding: f32) -> Vec<Layer> {
        let mut layers = Vec::new();
        let [n_in, n_out] = [self.n_in, self.n_out].map(|n| n.next_multiple_of(alignment));
        for i in 0..=self.n_hidden {
            let ins = if i == 0 { n_in } else { self.hidden };
            let outs = if i == self.n_hidden { n_out } else { self.hidden };
            let (weight, rest) = values.split_at(ins * outs);
            let layer = Layer::transposed([outs, ins], weight, Vec::new());
            layers.push(match i {
                0 => layer.without_padding(self.n_in, padding),
                _ if i == self.n_hidden => layer.outputs(0..self.n_out),
                _ => layer,
            });
            values = rest;
        }
        layers
    }
}

/// Which levels are hashed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hashed {
    /// Those with more corners than this.
    Beyond(u32),
    /// None.
    Never,
}

/// The grid that instant-ngp makes of a configuration under `name`; without a growth of
/// its own, the finest level has `finest` cells.
pub(super) fn grid(
    settings: Settings<'_, '_>,
    name: &str,
    finest: f32,
) -> Result<(Shape, Hashed), FieldError> {
    let key = |key: &str| format!("{name}.{key}");
    let otype = settings.choice(&key("otype"), "", &["HashGrid", "DenseGrid", "Grid"])?;
    let kind = match otype {
        "HashGrid" => "Hash",
        "DenseGrid" => "Dense",
        _ => settings.choice(&key("type"), "Hash", &["Hash", "Dense"])?,
    };
    settings.choice(&key("hash"), "CoherentPrime", &["CoherentPrime"])?;
    settings.choice(&key("interpolation"), "Linear", &["Linear"])?;
    let n_features = settings.count(&key("n_features_per_level"), 2, 1..=8)?;
    let all = settings.count(&key("n_features"), 0, 0..=128)?;
    let n_levels = match all / n_features {
        0 => settings.count(&key("n_levels"), 16, 1..=16)?,
        n if n <= 16 => n,
        n => {
            return Err(setting(
                &key("n_features"),
                &all.to_string(),
                &format!("levels, {n}, at most 16"),
            ));
        }
    };
    let log2 = settings.count(&key("log2_hashmap_size"), 15, 3..=24)?;
    let base_resolution = match settings.count(&key("base_resolution"), 0, 0..=1 << 16)? {
        0 => 1 << (log2 / 3),
        own => own,
    };
    let own = settings.0.number(&key("per_level_scale")).filter(|scale| *scale > 0.0);
    let per_level_scale = own.map_or_else(
        || ((finest / base_resolution as f32).ln() / (n_levels.max(2) - 1) as f32).exp(),
        |scale| scale as f32,
    );
    let shape = Shape { n_levels, n_features, base_resolution, per_level_scale, shift: 0.5 };
    Ok((shape, if kind == "Hash" { Hashed::Beyond(1 << log2) } else { Hashed::Never }))
}

/// The levels of such a grid, rounded as tiny-cuda-nn rounds: in f32.
pub(super) fn levels(shape: &Shape, hashed: Hashed) -> Result<Vec<CornerLevel>, FieldError> {
    let log2 = shape.per_level_scale.log2();
    let level = |l: u32| {
        let scale = (l as f32 * log2).exp2() * shape.base_resolution as f32 - 1.0;
        let side = (scale.ceil() as u64).saturating_add(1);
        let corners = side.saturating_pow(3);
        let (side, entries) = match hashed {
            Hashed::Beyond(most) if corners > most.into() => (0, most),
            _ => {
                let entries = corners.checked_next_multiple_of(8).filter(|n| *n <= 1 << 24);
                let entries = entries.ok_or_else(|| {
                    setting("corners of a dense level", &corners.to_string(), "at most 2^24")
                })? as u32;
                // Rounded up to eights, they may be more than fit the table.
                let most = if let Hashed::Beyond(most) = hashed { most } else { entries };
                (side as u32, entries.min(most))
            }
        };
        Ok(CornerLevel { scale, side, entries })
    };
    (0..shape.n_levels).map(level).collect()
}
