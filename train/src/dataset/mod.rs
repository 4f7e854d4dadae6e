//! Posed images: what training and evaluation read.
//!
//! One file per convention, recognised by content.

mod blender;
mod capture;
mod colmap;
mod decode;
mod deepvoxels;
mod error;
mod fingerprint;
mod footage;
mod holdout;
mod images;
mod intrinsics;
mod listing;
mod llff;
mod memory;
mod npy;
mod phone;
mod recognise;
mod report;
mod survey;
mod transforms;
mod turn;
mod view;
mod write;

use std::fmt;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;

pub use capture::Own;
pub use error::DatasetError;
#[doc(hidden)]
pub use fingerprint::hash_of;
pub use footage::{Footage, are_of_one_size, photographs};
pub use report::{
    DatasetReport, ImageSize, SplitReport, Suspicion, inspect, inspect_with, picture,
};
pub(crate) use view::UNCLAIMED;
pub use view::View;
pub use write::write;

use listing::Listing;
use recognise::{Convention, recognise};

/// How to read a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Images are downscaled by this factor along each side.
    pub downscale_factor: u32,
    /// Where a dataset has no splits of its own, every so many images are held out for
    /// test and val, in the order of their names from the first on. 0: all train.
    pub hold_every: u32,
    /// Treat an LLFF capture as one around a point: that point becomes the origin.
    pub spherify: bool,
    /// Reading images is given up then: a run that has no time for it ends early, with an
    /// error.
    pub deadline: Option<Instant>,
    /// Images that need more memory than this, bytes, are refused before any is decoded.
    pub memory: Option<u64>,
}

impl Default for LoadOptions {
    /// Whole images, every eighth held out.
    fn default() -> Self {
        let (spherify, deadline, memory) = (false, None, None);
        Self { downscale_factor: 1, hold_every: 8, spherify, deadline, memory }
    }
}

/// Reads one split of the dataset in the folder `path`: every frame, in the
/// dataset's order, with images `downscale_factor` times smaller along each
/// side (1 keeps them).
///
/// # Errors
/// One line: which file, what was found, what was expected and what to do.
pub fn load(path: &Path, split: Split, downscale_factor: u32) -> Result<Dataset, DatasetError> {
    load_with(path, split, &LoadOptions { downscale_factor, ..LoadOptions::default() })
}

/// The same with all options.
///
/// # Errors
/// As [`load`].
pub fn load_with(
    path: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Dataset, DatasetError> {
    let listing = list(path, split, options)?;
    let downscale_factor = listing.factor.unwrap_or(options.downscale_factor);
    let options = &LoadOptions { downscale_factor, ..*options };
    let (views, found) = decode::views(&listing, options)?;
    let Listing { format, bounds, aabb, reach, background, own, metres, .. } = listing;
    let (forward_facing, mut notes) = (listing.forward_facing, listing.notes);
    notes.extend(found);
    let dataset = Dataset::new(path.display().to_string(), format, split, views);
    notes.extend_from_slice(&dataset.notes);
    Ok(Dataset { bounds, aabb, reach, background, forward_facing, own, metres, notes, ..dataset })
}

/// Camera-to-world poses of all frames of the dataset in the folder `path`, of all its splits. No
/// image is read.
///
/// # Errors
/// As [`load`], except for what is wrong with images.
pub fn poses(path: &Path, options: &LoadOptions) -> Result<Vec<[f32; 16]>, DatasetError> {
    recognise(path)?;
    let splits = Split::ALL.into_iter().filter_map(|split| list(path, split, options).ok());
    Ok(splits.flat_map(|listing| listing.frames).map(|frame| frame.pose).collect())
}

/// The frames of a split, before any image is decoded.
fn list(path: &Path, split: Split, options: &LoadOptions) -> Result<Listing, DatasetError> {
    let convention = recognise(path)?;
    if options.spherify && convention != Convention::Llff {
        return Err(DatasetError::Spherify(path.to_owned()));
    }
    let mut listing = match convention {
        Convention::Blender => blender::list(path, split)?,
        Convention::Transforms => transforms::list(path, split, options)?,
        Convention::Llff => llff::list(path, split, options)?,
        Convention::Colmap => colmap::list(path, split, options)?,
        Convention::DeepVoxels => deepvoxels::list(path, split)?,
        Convention::Phone(app) => phone::list(app, path, split, options)?,
        Convention::Survey(program) => survey::list(program, path, split, options)?,
    };
    if listing.folder.as_os_str().is_empty() {
        listing.folder = path.to_owned();
    }
    capture::surround(&mut listing);
    Ok(listing)
}

/// The mean of the sides of squares with as many pixels as images of such sizes, so many of each.
fn pixels_across(sizes: impl Iterator<Item = ([u32; 2], usize)>) -> f32 {
    let (mut sum, mut all) = (0.0, 0);
    for ([width, height], n) in sizes {
        sum += (width as f32 * height as f32).sqrt() * n as f32;
        all += n;
    }
    sum / all.max(1) as f32
}

impl Dataset {
    /// What a model file calls it: the last part of its source.
    #[must_use]
    pub fn name(&self) -> String {
        let name = Path::new(&self.source).file_name();
        name.map_or_else(String::new, |name| name.display().to_string())
    }

    /// Pixels across the views: the mean of the sides of squares with as many pixels.
    #[must_use]
    pub fn pixels_across(&self) -> f32 {
        let size = |view: &View| [view.camera.width, view.camera.height];
        pixels_across(self.views.iter().map(|view| (size(view), 1)))
    }

    /// Keeps at most `n` views, spread evenly.
    pub fn thin(&mut self, n: usize) {
        thin(&mut self.views, n);
    }
}

/// Keeps at most `n` of a list, spread evenly.
pub fn thin<T>(list: &mut Vec<T>, n: usize) {
    let all = list.len();
    if n < all {
        let mut number = 0..all;
        // The first, and then each that begins another n-th part.
        list.retain(|_| number.next().is_some_and(|i| i * n % all < n));
    }
}

/// Images are cut-outs where at least one pixel in so many is transparent.
const CUT_OUT: usize = 1000;

/// Which part of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Split {
    /// Views to learn from.
    Train,
    /// Views to choose settings with.
    Val,
    /// Views to report on.
    Test,
}

impl Split {
    /// All splits.
    pub const ALL: [Self; 3] = [Self::Train, Self::Val, Self::Test];

    /// `train`, `val` or `test`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Val => "val",
            Self::Test => "test",
        }
    }
}

impl fmt::Display for Split {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for Split {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|split| split.name() == text)
            .ok_or_else(|| format!("{text:?} is no split, expected train, val or test"))
    }
}

/// The views of one split.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// What was loaded: a path, or the name of the built-in scene.
    pub source: String,
    /// The convention that was recognised.
    pub format: &'static str,
    /// Which split.
    pub split: Split,
    /// The views, in the dataset's order.
    pub views: Vec<View>,
    /// Whether the images are cut-outs: at least one in a thousand of the pixels that count is
    /// transparent. Fewer are the flaws of opaque images.
    pub has_alpha: bool,
    /// Nearest and farthest depth, scene units, where the dataset says.
    pub bounds: Option<[f32; 2]>,
    /// The scene's box, smallest and largest corner, where the dataset says.
    pub aabb: Option<[[f32; 3]; 2]>,
    /// The box around what opaque images show, where points of the scene are known.
    pub reach: Option<[[f32; 3]; 2]>,
    /// The colour that opaque images show where nothing is, where the dataset says, or their
    /// [edges](Self::cut_out) do.
    pub background: Option<[f32; 3]>,
    /// Whether all cameras look along −z from about the origin, at what lies beyond
    /// z = −1: rays that suit normalised device coordinates.
    pub forward_facing: bool,
    /// The coordinates of its files, where it was moved as it was read.
    pub own: Option<Own>,
    /// Metres per unit of its files, where that is known.
    pub metres: Option<f32>,
    /// What the user should know, a line each: frames that were left out, and the like.
    pub notes: Vec<String>,
}

impl Dataset {
    /// Views of a scene of which nothing else is known.
    #[must_use]
    pub fn new(
        source: impl Into<String>,
        format: &'static str,
        split: Split,
        views: Vec<View>,
    ) -> Self {
        let counts = views.par_iter().map(View::transparent);
        let [transparent, all] = counts.reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        let has_alpha = transparent > 0 && transparent >= all / CUT_OUT;
        let notes = match transparent > 0 && !has_alpha {
            true => vec![format!(
                "{transparent} of {all} pixels are transparent: too few for cut-outs, the images \
                 count as opaque"
            )],
            false => Vec::new(),
        };
        Self {
            source: source.into(),
            format,
            split,
            views,
            has_alpha,
            bounds: None,
            aabb: None,
            reach: None,
            background: None,
            forward_facing: false,
            own: None,
            metres: None,
            notes,
        }
    }
}
