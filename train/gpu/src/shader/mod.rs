//! The program that a GPU runs, in WGSL: files of this folder, which are the same for all
//! models, behind the constants and the layers of one.
//!
//! A pixel is an invocation: [`ray.wgsl`](RAY) makes its ray, `space_*.wgsl` takes it into the
//! coordinates of the space, `march.wgsl` or `hierarchical.wgsl` finds samples along it, with
//! `cells.wgsl` to skip what is empty, and asks the field: `hash_grid.wgsl` and `decoder.wgsl`,
//! or `vanilla.wgsl`.

mod constants;
mod hash_grid;
mod network;
#[cfg(feature = "nerf")]
mod vanilla;

use alloc::string::String;
use alloc::vec;

use pocketnerf_core::march::{Hierarchical, MAX_STEPS, Reach};
use pocketnerf_core::render::SamplingMode;
use pocketnerf_core::{Model, RenderOptions, Space};

use crate::pack::{Packed, PackedField};
use constants::Constants;

/// Rays and pixels.
const RAY: &str = include_str!("wgsl/ray.wgsl");

/// The program that renders `model`, whose buffers are `packed`.
#[must_use]
pub fn source(model: &Model<'_>, packed: &Packed, options: &RenderOptions) -> String {
    let mut constants = Constants::default();
    let mut files = vec![RAY, include_str!("wgsl/enter.wgsl")];
    files.push(space(&mut constants, &model.space));
    files.push(match &model.occupancy {
        Some(occupancy) => {
            constants.whole("RESOLUTION", occupancy.resolution());
            include_str!("wgsl/cells.wgsl")
        }
        None => include_str!("wgsl/no_cells.wgsl"),
    });
    let sampling = &model.sampling;
    constants.number("STEP", sampling.step);
    constants.number("NEAR", sampling.near);
    constants.number("FAR", sampling.far);
    files.push(match options.sampling {
        SamplingMode::Occupancy => {
            constants.number("MAX_STEPS", MAX_STEPS as f32);
            constants.whole("MAX_SAMPLES", options.max_samples_per_pixel.saturating_add(1));
            constants.flag("SKIP", options.skip);
            include_str!("wgsl/march.wgsl")
        }
        SamplingMode::Hierarchical(hierarchical) => {
            hierarchical_constants(&mut constants, &hierarchical, &model.space);
            include_str!("wgsl/hierarchical.wgsl")
        }
    });
    let mut generated = String::new();
    let is_hierarchical = matches!(options.sampling, SamplingMode::Hierarchical(_));
    match &packed.field {
        PackedField::HashGrid(grid) => {
            hash_grid::write(grid, is_hierarchical, &mut constants, &mut files, &mut generated);
        }
        #[cfg(feature = "nerf")]
        PackedField::Vanilla(field) => {
            vanilla::write(field, is_hierarchical, &mut constants, &mut files, &mut generated);
        }
    }
    [constants.text(), &files.join("\n"), &generated].join("\n")
}

/// The constants of a space, and its file.
fn space(constants: &mut Constants, space: &Space) -> &'static str {
    let [min, max] = space.bounds();
    constants.point("BOX_MIN", min);
    constants.point("BOX_MAX", max);
    constants.number("UNIT_SCALE", space.unit_map().scale);
    match space {
        #[cfg(feature = "ndc")]
        Space::Ndc(ndc) => {
            constants.number("NDC_NEAR", ndc.near);
            constants.pair("NDC_SLOPE", ndc.slope);
            include_str!("wgsl/space_ndc.wgsl")
        }
        _ => include_str!("wgsl/space_box.wgsl"),
    }
}

fn hierarchical_constants(constants: &mut Constants, hierarchical: &Hierarchical, space: &Space) {
    let Hierarchical { n_coarse, n_fine, reach } = *hierarchical;
    constants.whole("N_COARSE", n_coarse);
    constants.whole("N_FINE", n_fine);
    constants.flag("CLIPPED", reach == Reach::Clipped);
    // Elsewhere a ray has samples along all of its way.
    constants.flag("BY_DEPTH", reach == Reach::Depth && matches!(space, Space::Box { .. }));
    // What the last sample stands for.
    constants.number("LAST", if reach == Reach::Clipped { 0.0 } else { 1e10 });
}
