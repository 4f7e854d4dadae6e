//! A model in fewer bytes than packing alone gives, without photographs: values of its tables and
//! networks are rounded to multiples of coarser steps, a step a table or matrix, chosen so that
//! pictures change least for the bytes that are saved.
//!
//! Fine levels of a hash grid bear coarse steps: their part of a picture is small. What each step of
//! each part does to pictures and to bytes is measured, one part at a time; their errors add up.

mod candidates;
mod choice;
mod error;
mod networks;
mod parts;
pub(crate) mod pictures;
mod search;
mod tables;

use pocketnerf_core::{Camera, Error, Model};
use pocketnerf_formats::{open, pack, unpacked};

pub use error::CompactError;
pub use pictures::{SIDE, VIEWS, small};

use crate::picture::Settings;
use choice::{choose, coarsest};
use pictures::Difference;
use search::{Search, Whole, lengths_of};

/// A model that was made smaller.
#[derive(Clone, Debug, PartialEq)]
pub struct Compacted {
    /// The packed file.
    pub bytes: Vec<u8>,
    /// The step of each table, in units of the stored values; 1: as it was.
    pub steps: Vec<u16>,
    /// The step of each large matrix of the networks, in the same way.
    pub network_steps: Vec<u16>,
    /// The lengths of these steps.
    pub lengths: Vec<f32>,
    /// Its pictures against the model's own, over the model's background, all pixels together,
    /// dB; infinite where nothing changed.
    pub psnr: f64,
}

/// Packs the ordinary `file` into at most `most` bytes. Pictures are compared from `cameras`, of
/// which a dozen small ones suffice. Where training has got used to steps of some `lengths`, a
/// table each, these are only refined, if they fit.
///
/// # Errors
/// [`CompactError::TooSmall`] if no choice of steps is that small; what opening, rendering or
/// writing reports.
pub fn to_bytes(
    file: &[u8],
    most: usize,
    lengths: Option<&[f32]>,
    cameras: &[Camera],
    settings: &Settings,
) -> Result<Compacted, CompactError> {
    let packed = pack(file)?;
    if packed.len() <= most {
        return unchanged(packed);
    }
    let whole = Whole::read(&packed, cameras, settings)?;
    let file = whole.in_eight_bits()?;
    let search = Search::begin(&whole, &file, lengths)?;
    let mut least = usize::MAX;
    let chosen = choose(&search.candidates, &search.known(), |chosen| {
        let bytes = search.packed(chosen)?.len();
        least = least.min(bytes);
        Ok::<_, CompactError>(bytes <= most)
    })?;
    let Some(chosen) = chosen else { return Err(CompactError::TooSmall { most, least }) };
    search.compacted(&chosen)
}

/// Pictures of a smaller model may take so many times as many samples: where density becomes less,
/// light passes further.
const MOST_WORK: f64 = 2.0;

/// Packs the ordinary `file` into as few bytes as possible while the model renders as fast and is
/// good, which `is_good` is asked, given the mean squared difference to the file's own pictures from
/// `cameras`. Where none is good, nothing is rounded.
///
/// # Errors
/// What opening, rendering or writing reports.
pub fn smallest(
    file: &[u8],
    cameras: &[Camera],
    settings: &Settings,
    mut is_good: impl FnMut(&Model<'_>, f64) -> Result<bool, Error>,
) -> Result<Compacted, CompactError> {
    let packed = pack(file)?;
    let whole = Whole::read(&packed, cameras, settings)?;
    let file = whole.in_eight_bits()?;
    let search = Search::begin(&whole, &file, None)?;
    let chosen = coarsest(&search.candidates, |chosen| {
        let file = search.rounded(chosen)?;
        let model = open(&file)?.model;
        let Difference { error, work } = whole.pictures.difference(&model)?;
        Ok::<_, CompactError>(work <= MOST_WORK && is_good(&model, error)?)
    })?;
    match chosen {
        Some(chosen) => search.compacted(&chosen),
        None => unchanged(packed),
    }
}

/// How often pictures of all views are rendered and a file is packed to find a size, about, where
/// a model has so many tables.
pub(crate) const fn work(tables: usize) -> [usize; 2] {
    /// Large matrices of the networks.
    const MATRICES: usize = 4;
    let [of_table, of_matrix] = candidates::LOOKS;
    let tried = choice::HALVINGS + tables + MATRICES;
    [of_table * tables + of_matrix * MATRICES + tried, tried + candidates::RATES]
}

/// With no step longer than a unit.
fn unchanged(packed: Vec<u8>) -> Result<Compacted, CompactError> {
    let file = unpacked(&packed)?;
    let model = open(&file)?.model;
    let (steps, network_steps) = (vec![1; tables::all(&model).len()], Vec::new());
    let lengths = lengths_of(&model, &steps);
    Ok(Compacted { bytes: packed, steps, network_steps, lengths, psnr: f64::INFINITY })
}
