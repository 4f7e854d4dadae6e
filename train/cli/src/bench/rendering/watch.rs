//! A picture with a stopwatch between the renderer's stages.

use fearless_simd::dispatch;
use pocketnerf_core::march::{LANES, Marcher, RayPacket};
use pocketnerf_core::render::{self, Tiles, observe_tile};
use pocketnerf_core::{Camera, Error, Model, Ray, RenderOptions};
use pocketnerf_train::stopwatch::{Laps, Stage, Stopwatch};

/// Counts of a picture.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Pixels.
    pub(super) pixels: u64,
    /// Rays cast.
    pub(super) rays: u64,
    /// Samples that were evaluated.
    pub(super) samples: u64,
    /// Samples including the padding of batches.
    pub(super) rows: u64,
    /// Rays that met an occupied cell.
    pub(super) hits: u64,
}

/// Renders a picture on this thread, discards it, and adds to `counts`.
pub(super) fn watch(
    model: &Model<'_>,
    camera: &Camera,
    options: &RenderOptions,
    stopwatch: &Stopwatch,
    counts: &mut Counts,
) -> Result<(), Error> {
    let mut scratch = vec![0.0; options.scratch_len()];
    let mut rgba = Vec::new();
    for tile in Tiles::new(camera.width, camera.height) {
        rgba.resize(4 * tile.pixels(), 0.0);
        counts.pixels += tile.pixels() as u64;
        let mut laps = Laps::begin(Some(stopwatch));
        observe_tile(model, camera, tile, options, &mut scratch, &mut rgba, &mut |stage, n| {
            laps.end(named(stage), n);
            match stage {
                render::Stage::Camera => counts.rays += n as u64,
                render::Stage::Shade => counts.hits += n as u64,
                render::Stage::Density => {
                    counts.samples += n as u64;
                    counts.rows += n.next_multiple_of(16) as u64;
                }
                _ => {}
            }
        })?;
    }
    Ok(())
}

fn named(stage: render::Stage) -> Stage {
    match stage {
        render::Stage::Interpolate => Stage::Interpolate,
        render::Stage::Camera => Stage::Camera,
        render::Stage::March => Stage::March,
        render::Stage::Encode => Stage::Encode,
        render::Stage::Density => Stage::Density,
        render::Stage::Composite => Stage::Composite,
        _ => Stage::Color,
    }
}

/// The rays that meet nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Empty {
    /// Rays that cross only empty cells of the box.
    pub(super) rays: Vec<Ray>,
    /// All pixels whose rays meet nothing.
    pub(super) pixels: u64,
}

/// The rays of a picture that meet nothing, at most `most`.
pub(super) fn empty(
    model: &Model<'_>,
    camera: &Camera,
    options: &RenderOptions,
    most: usize,
) -> Result<Empty, Error> {
    let level = options.simd.token()?;
    let marcher = Marcher::new(model, options.skip);
    let mut found = Empty::default();
    for i in 0..camera.width * camera.height {
        let ray = camera.ray((i % camera.width) as f32 + 0.5, (i / camera.width) as f32 + 0.5);
        let mut packet = RayPacket::EMPTY;
        packet.set(0, &ray, 0.5);
        dispatch!(level, simd => marcher.enter(simd, &mut packet));
        (1..LANES).for_each(|lane| packet.stop(lane));
        let entered = packet.n_active() > 0;
        dispatch!(level, simd => marcher.seek(simd, &mut packet));
        found.pixels += u64::from(packet.n_active() == 0);
        if entered && packet.n_active() == 0 && found.rays.len() < most {
            found.rays.push(ray);
        }
    }
    Ok(found)
}
