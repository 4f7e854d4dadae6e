//! The program that a GPU runs, in WGSL: files of this folder, which are the same for all
//! models, behind the constants and the layers of one.
//!
//! A pixel is an invocation: `ray.wgsl` makes its ray, `space_*.wgsl` takes it into the
//! coordinates of the space, where it is `straight.wgsl` or a few straight pieces, `march.wgsl`
//! or `hierarchical.wgsl` finds samples along it, with `cells.wgsl` to skip what is empty, and
//! asks the field: `hash_grid.wgsl` or `planes.wgsl` and `decoder.wgsl`, or `vanilla.wgsl`. Where
//! colours are those of rays, there is a second program, `shade`, with the feature `wgpu`:
//! workgroups compute them together.

mod encoded;
mod hash_grid;
mod network;
#[cfg(feature = "planes")]
mod planes;
mod text;
#[cfg(feature = "wgpu")]
mod together;
#[cfg(feature = "wgpu")]
mod training;
#[cfg(feature = "nerf")]
mod vanilla;

use alloc::string::String;

use pocketnerf_core::march::MAX_STEPS;
#[cfg(feature = "nerf")]
use pocketnerf_core::march::{Hierarchical, Reach};
#[cfg(feature = "nerf")]
use pocketnerf_core::render::SamplingMode;
use pocketnerf_core::{Model, RenderOptions, Space};

use crate::pack::{Packed, PackedField};
use encoded::Factors;
use text::Text;
#[cfg(feature = "wgpu")]
pub(crate) use training::{Rows, Together, source as training_source};

/// The program that renders `model`, whose buffers are `packed`. Samples are placed
/// hierarchically with the feature `nerf` alone, as by `pocketnerf_core`.
#[must_use]
pub fn source(model: &Model<'_>, packed: &Packed, options: &RenderOptions) -> String {
    let mut text = Text::default();
    text.file(wgsl!("ray"));
    scene(&mut text, model);
    text.number("STEP", model.sampling.step);
    text.number("PHASE", 0.5);
    let is_hierarchical = match options.sampling {
        #[cfg(feature = "nerf")]
        SamplingMode::Hierarchical(hierarchical) => {
            write_hierarchical(&mut text, &hierarchical, &model.space);
            true
        }
        _ => {
            text.whole("MAX_SAMPLES", options.max_samples_per_pixel.saturating_add(1));
            text.flag("SKIP", options.skip);
            text.file(wgsl!("stride"));
            text.file(wgsl!("march"));
            false
        }
    };
    match &packed.field {
        PackedField::Encoded(field) => {
            encoded::write(field, Factors::Constant, is_hierarchical, &mut text);
        }
        #[cfg(feature = "nerf")]
        PackedField::Vanilla(field) => vanilla::write(field, is_hierarchical, &mut text),
    }
    text.into_string()
}

/// Where rays go, and which cells they cross.
fn scene(text: &mut Text, model: &Model<'_>) {
    text.file(wgsl!("values"));
    text.file(wgsl!("place"));
    text.file(wgsl!("product"));
    space(text, &model.space);
    match &model.occupancy {
        Some(occupancy) => {
            text.whole("RESOLUTION", occupancy.resolution());
            text.file(wgsl!("cells"));
        }
        None => text.file(wgsl!("no_cells")),
    }
    text.number("NEAR", model.sampling.near);
    text.number("FAR", model.sampling.far);
    text.number("MAX_STEPS", MAX_STEPS as f32);
}

/// Quads of numbers that the program `render` leaves a pixel for the program `shade`, which turns
/// them into its colour; 0: the colours are there, and there is no such program.
#[must_use]
pub fn quads_to_shade(packed: &Packed) -> usize {
    match &packed.field {
        PackedField::Encoded(field) if encoded::is_shaded(field) => field.n_feature_quads,
        _ => 0,
    }
}

/// The constants of a space, and its file.
fn space(text: &mut Text, space: &Space) {
    let [min, max] = space.bounds();
    text.point("BOX_MIN", min);
    text.point("BOX_MAX", max);
    text.number("UNIT_SCALE", space.unit_map().scale);
    match space {
        #[cfg(feature = "contracted")]
        Space::Contracted(contracted) => {
            text.point("CENTER", contracted.center);
            text.number("RADIUS", contracted.radius);
            text.file(wgsl!("space_contracted"));
            return;
        }
        #[cfg(feature = "ndc")]
        Space::Ndc(ndc) => {
            text.number("NDC_NEAR", ndc.near);
            text.pair("NDC_SLOPE", ndc.slope);
            text.file(wgsl!("space_ndc"));
        }
        _ => text.file(wgsl!("space_box")),
    }
    text.file(wgsl!("straight"));
}

#[cfg(feature = "nerf")]
fn write_hierarchical(text: &mut Text, hierarchical: &Hierarchical, space: &Space) {
    let Hierarchical { n_coarse, n_fine, reach } = *hierarchical;
    text.whole("N_COARSE", n_coarse);
    text.whole("N_FINE", n_fine);
    text.flag("CLIPPED", reach == Reach::Clipped);
    // Elsewhere a ray has samples along all of its way.
    text.flag("BY_DEPTH", reach == Reach::Depth && matches!(space, Space::Box { .. }));
    // What the last sample stands for.
    text.number("LAST", if reach == Reach::Clipped { 0.0 } else { 1e10 });
    text.file(wgsl!("hierarchical"));
}
