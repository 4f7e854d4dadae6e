//! How much neighbouring pixels may differ where one between them is
//! interpolated, found on tiles of the training views.

use pocketnerf_core::render::{Detail, rehearse_tile};
use pocketnerf_core::{Error, Model, RenderOptions, SimdLevel, Tuning};

use crate::trainer::finish::calibration_tiles::{CalibrationTile, CalibrationTiles};

/// Tolerances to choose from.
const LADDER: [f32; 11] = [0.2, 0.16, 0.13, 0.1, 0.08, 0.065, 0.05, 0.04, 0.03, 0.02, 0.01];
/// Loss that is borne, dB of the training views' PSNR.
const LOSS: f64 = 0.03;

/// Calibration tiles.
pub(crate) const TILES: usize = 48;

/// Squared errors of one tile: with every tolerance of the ladder, and rendered whole.
type Errors = ([f64; LADDER.len()], f64);

/// The [tolerance](pocketnerf_core::Display::tolerance) for a model: the largest
/// with which pictures of the training views hardly differ more from the
/// photographs than without.
pub(crate) fn find(
    model: &Model<'_>,
    tiles: &CalibrationTiles<'_>,
    simd: SimdLevel,
) -> Result<f32, Error> {
    let usual = RenderOptions::new(model, simd, Tuning::FAST);
    let detail = Detail { tolerances: [0.0; 4], ..usual.detail };
    let errors = tiles.render(model, &RenderOptions { detail, ..usual }, try_all)?;
    let (mut rough, mut fine) = ([0.0; LADDER.len()], 0.0);
    for (errors, whole) in errors {
        rough.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error);
        fine += whole;
    }
    let bearable = fine * 10.0f64.powf(LOSS / 10.0);
    let borne = LADDER.iter().zip(rough).find(|(_, error)| *error <= bearable);
    Ok(borne.map_or(0.0, |(tolerance, _)| *tolerance))
}

/// Tries every tolerance on a tile.
fn try_all(tile: &CalibrationTile<'_>) -> Result<Errors, Error> {
    let mut rough = vec![0.0; tile.rgba.len()];
    let mut errors = [0.0; LADDER.len()];
    for (error, tolerance) in errors.iter_mut().zip(LADDER) {
        let detail = Detail { tolerances: [tolerance, 0.0, 0.0, 0.0], ..Detail::FINEST };
        rehearse_tile([tile.tile.width, tile.tile.height], &detail, &tile.rgba, &mut rough)?;
        *error = tile.squared_error(&rough);
    }
    Ok((errors, tile.squared_error(&tile.rgba)))
}
