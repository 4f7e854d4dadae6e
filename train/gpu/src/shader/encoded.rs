//! An encoding and the networks behind it.

use pocketnerf_core::field::MAX_SIGMA;

use super::hash_grid;
use super::network::{channels, function};
#[cfg(feature = "planes")]
use super::planes;
use super::text::{Text, line};
#[cfg(feature = "wgpu")]
use super::together;
use crate::pack::{PackedEncoded, PackedEncoding, reader};

/// What stored values are multiplied by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Factors {
    /// What the model says.
    Constant,
    /// What a buffer says, a number a level: they change while a field learns.
    #[cfg(feature = "wgpu")]
    Buffer,
}

impl Factors {
    fn is_training(self) -> bool {
        self != Self::Constant
    }
}

/// Adds what evaluates the field.
pub(super) fn write(
    field: &PackedEncoded,
    factors: Factors,
    is_hierarchical: bool,
    text: &mut Text,
) {
    text.number("MAX_SIGMA", MAX_SIGMA);
    text.number("LOG_DENSITY_BIAS", field.log_density_bias);
    for (name, value) in
        [("N_FEATURE_QUADS", field.n_feature_quads), ("N_HARMONICS", field.n_harmonics)]
    {
        text.whole(name, value as u32);
    }
    if let Some(reader) = field.dtype.and_then(reader) {
        text.file(reader);
    }
    match &field.encoding {
        PackedEncoding::HashGrid(grid) => hash_grid::encode(grid, factors, text),
        #[cfg(feature = "planes")]
        PackedEncoding::Planes(packed) => planes::encode(packed, text),
    }
    text.file(wgsl!("decoder"));
    let n_features = field.n_feature_quads;
    line!(text, "fn features_of(all: array<vec4f, {}>) -> Features {{", n_features + 1);
    line!(text, "return Features(");
    (0..n_features).for_each(|i| line!(text, "all[{i}],"));
    line!(text, ");\n}}");
    channels(text, if field.per_ray { n_features } else { 1 });
    text.file(match field.per_ray {
        true => wgsl!("decoded_per_ray"),
        false => wgsl!("decoded_per_sample"),
    });
    if factors.is_training() {
        // Its kernels have the colour network.
    } else if is_shaded(field) {
        #[cfg(feature = "wgpu")]
        together::write(text, n_features, &field.color);
    } else {
        text.file(wgsl!("decoded_color"));
        function(text, "color_network", &field.color);
        text.file(wgsl!("shaded"));
        if field.per_ray {
            text.file(wgsl!("color_of_mean"));
        }
    }
    if is_hierarchical {
        text.file(wgsl!("decoded_coarse"));
    }
    function(text, "density_network", &field.density);
}

/// Whether colours are computed by a program of their own.
#[cfg(feature = "wgpu")]
pub(super) fn is_shaded(field: &PackedEncoded) -> bool {
    field.per_ray && together::fits(&field.color)
}

/// Never, where programs are to be short.
#[cfg(not(feature = "wgpu"))]
pub(super) const fn is_shaded(_: &PackedEncoded) -> bool {
    false
}
