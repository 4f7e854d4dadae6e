//! How much neighbouring pixels may differ where one between them is
//! interpolated: what the scene bears, tried on tiles of the training views.

use pocketnerf_core::render::{Detail, rehearse_tile};
use pocketnerf_core::{Camera, Error, Model, RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use rayon::prelude::*;

use super::rays::RaySource;
use crate::picture::TILE;
use crate::random::Random;

/// Tolerances to choose from.
const LADDER: [f32; 11] = [0.2, 0.16, 0.13, 0.1, 0.08, 0.065, 0.05, 0.04, 0.03, 0.02, 0.01];
/// Loss that is borne, dB of the training views' PSNR.
const LOSS: f64 = 0.03;
/// Tiles that are tried.
const TILES: usize = 48;
/// Distinguishes these random numbers from others of the same seed.
const STREAM: u64 = 4;

/// Squared errors of one tile: with every tolerance of the ladder, and rendered whole.
type Errors = ([f64; LADDER.len()], f64);

/// The [tolerance](pocketnerf_core::Display::tolerance) for a model: the largest
/// with which pictures of the training views hardly differ more from the
/// photographs than without.
pub(super) fn find(
    model: &Model<'_>,
    source: &RaySource,
    seed: u64,
    simd: SimdLevel,
) -> Result<f32, Error> {
    let usual = RenderOptions::new(model, simd, Tuning::FAST);
    let detail = Detail { tolerances: [0.0; 4], ..usual.detail };
    let options = RenderOptions { detail, ..usual };
    let tiles: Result<Vec<Errors>, Error> = (0..TILES)
        .into_par_iter()
        .with_max_len(1)
        .map_init(
            || vec![0.0; options.scratch_len()],
            |scratch, number| {
                let mut random = Random::new(seed, [STREAM, number as u64, 0]);
                try_tile(model, &options, source, &mut random, scratch)
            },
        )
        .collect();
    let (mut rough, mut fine) = ([0.0; LADDER.len()], 0.0);
    for (errors, whole) in tiles? {
        rough.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error);
        fine += whole;
    }
    let bearable = fine * 10.0f64.powf(LOSS / 10.0);
    let borne = LADDER.iter().zip(rough).find(|(_, error)| *error <= bearable);
    Ok(borne.map_or(0.0, |(tolerance, _)| *tolerance))
}

/// Renders a random tile of a random view, and tries every tolerance on it.
fn try_tile(
    model: &Model<'_>,
    options: &RenderOptions,
    source: &RaySource,
    random: &mut Random,
    scratch: &mut [f32],
) -> Result<Errors, Error> {
    let view = random.below(source.cameras().len());
    let (camera, photograph) = (&source.cameras()[view], &source.images()[view]);
    let [width, height] = [TILE[0].min(camera.width), TILE[1].min(camera.height)];
    let mut corner = |side: u32, tile: u32| random.below((side - tile) as usize + 1) as u32;
    let (x, y) = (corner(camera.width, width), corner(camera.height, height));
    let tile = Tile { x, y, width, height };
    let [mut finest, mut rough] = [vec![0.0; 4 * tile.pixels()], vec![0.0; 4 * tile.pixels()]];
    render_tile(model, camera, tile, options, scratch, &mut finest, None)?;
    let background = model.display.background;
    let error = |rgba: &[f32]| squared_error(rgba, tile, (camera, photograph), background);
    let mut errors = [0.0; LADDER.len()];
    for (error_of, tolerance) in errors.iter_mut().zip(LADDER) {
        let detail = Detail { tolerances: [tolerance, 0.0, 0.0, 0.0], ..Detail::FINEST };
        rehearse_tile([width, height], &detail, &finest, &mut rough)?;
        *error_of = error(&rough);
    }
    Ok((errors, error(&finest)))
}

/// Of a tile's premultiplied pixels against those of the photograph, both over
/// the background, all colours together.
fn squared_error(
    rgba: &[f32],
    tile: Tile,
    (camera, photograph): (&Camera, &[u8]),
    background: [f32; 3],
) -> f64 {
    let rows = photograph.chunks_exact(4 * camera.width as usize).skip(tile.y as usize);
    let truth = rows
        .flat_map(|row| row[4 * tile.x as usize..][..4 * tile.width as usize].as_chunks::<4>().0);
    let pixels = rgba.as_chunks::<4>().0.iter().zip(truth);
    let errors = pixels.map(|(ours, theirs)| {
        let [r, g, b, alpha] = theirs.map(|value| f32::from(value) / 255.0);
        let seen = ours[3];
        let differences = [r, g, b].into_iter().zip(ours).zip(background);
        let squares = differences.map(|((theirs, ours), behind)| {
            let difference = theirs * alpha + (1.0 - alpha) * behind - ours - (1.0 - seen) * behind;
            f64::from(difference * difference)
        });
        squares.sum::<f64>()
    });
    errors.sum()
}
