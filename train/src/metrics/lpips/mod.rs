//! Learned perceptual similarity (LPIPS).

mod error;
mod features;
mod network;
#[cfg(test)]
mod tests;
mod weights;

use std::fmt;
use std::path::Path;

use pocketnerf_formats::import::Checkpoint;
use rayon::prelude::*;

pub use error::LpipsError;

use super::mask::Mask;
use features::Features;
use network::{Network, Step};
use weights::Convolution;

/// What features are divided by at least.
const EPSILON: f32 = 1e-10;

/// LPIPS v0.1: how different two pictures look, by the features of a network that was
/// trained to recognise things, AlexNet or VGG16, and weights learnt from people's
/// judgements.
///
/// Zhang, Isola, Efros, Shechtman, Wang: The unreasonable effectiveness of deep features as
/// a perceptual metric, 2018, equation 1. The weights are the user's.
pub struct Lpips {
    network: &'static Network,
    convolutions: Vec<Convolution>,
    /// For each tap, the weights of its channels.
    heads: Vec<Vec<f32>>,
}

impl Lpips {
    /// Reads a file of weights, `.npz`: kernels and biases of the convolutions and the heads
    /// (one weight a channel), either in flax's layout (height, width, in, out) or in torch's
    /// (out, in, height, width), as in the state of the Python package `lpips`. Tensors are
    /// told apart by their shapes, and ordered by their names.
    ///
    /// # Errors
    /// [`LpipsError`]: the file cannot be read, or its tensors are not those of a network.
    pub fn read(file: &Path) -> Result<Self, LpipsError> {
        let unreadable = |error| LpipsError::Unreadable { file: file.to_owned(), error };
        Self::from_bytes(&std::fs::read(file).map_err(unreadable)?, file)
    }

    /// The same from a file's bytes; its name is for messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_bytes(bytes: &[u8], file: &Path) -> Result<Self, LpipsError> {
        let checkpoint = Checkpoint::read(bytes)
            .map_err(|error| LpipsError::Checkpoint { file: file.to_owned(), error })?;
        weights::read(&checkpoint, file)
    }

    /// Whose features are compared: `AlexNet` or `VGG16`.
    #[must_use]
    pub fn network(&self) -> &'static str {
        self.network.name
    }

    /// The distance of two 8-bit RGB pictures: 0 for equal ones, about 1 for pictures that
    /// have nothing in common. `None` where a side is too small for the network (31 pixels
    /// for AlexNet, 16 for VGG16), or where the weights are so large that no number results.
    ///
    /// The number of threads changes nothing; machines with other vector instructions may
    /// differ in the last digits. VGG16 takes about 0.8 kB of memory a pixel.
    ///
    /// # Panics
    /// If a picture does not hold `width * height * 3` values.
    #[must_use]
    pub fn distance(
        &self,
        picture: &[u8],
        truth: &[u8],
        width: usize,
        height: usize,
    ) -> Option<f64> {
        self.masked_distance([picture, truth], [width, height], &Mask::NONE)
    }

    /// The same of the features whose middle counts; `None` where there is none.
    pub(super) fn masked_distance(
        &self,
        [picture, truth]: [&[u8]; 2],
        [width, height]: [usize; 2],
        mask: &Mask<'_>,
    ) -> Option<f64> {
        let size = width * height * 3;
        assert_eq!([picture.len(), truth.len()], [size; 2], "RGB pictures of that size");
        let mut both = [picture, truth].map(|rgb| Features::of_picture(rgb, width, height));
        let (mut convolutions, mut heads) = (self.convolutions.iter(), self.heads.iter());
        let mut distance = 0.0;
        for step in self.network.steps {
            match *step {
                Step::Convolve(shape) => {
                    let convolution = convolutions.next()?;
                    for features in &mut both {
                        *features = features.convolved(&shape, convolution)?;
                    }
                }
                Step::Pool { side } => {
                    for features in &mut both {
                        *features = features.pooled(side)?;
                    }
                }
                Step::Tap => distance += difference(&both, heads.next()?, mask)?,
            }
        }
        Some(distance).filter(|distance| distance.is_finite())
    }
}

impl fmt::Debug for Lpips {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Lpips").field("network", &self.network.name).finish_non_exhaustive()
    }
}

/// The mean over the pixels that count of the weighted squared differences of features, each
/// pixel's divided by their length.
fn difference([a, b]: &[Features; 2], head: &[f32], mask: &Mask<'_>) -> Option<f64> {
    let (row, size) = (a.width * a.channels, [a.width, a.height]);
    let rows = a.values.par_chunks_exact(row).zip(b.values.par_chunks_exact(row));
    let sums: Vec<(f64, usize)> = rows
        .enumerate()
        .map(|(y, (a, b))| {
            let pixels = a.chunks_exact(head.len()).zip(b.chunks_exact(head.len()));
            let counted = pixels.enumerate().filter(|(x, _)| mask.counts([*x, y], size));
            counted.fold((0.0, 0), |(sum, n), (_, (a, b))| {
                (sum + f64::from(pixel_difference(a, b, head)), n + 1)
            })
        })
        .collect();
    let n: usize = sums.iter().map(|(_, n)| n).sum();
    // Summed row after row, so that the number of threads changes nothing.
    (n > 0).then(|| sums.iter().map(|(sum, _)| sum).sum::<f64>() / n as f64)
}

fn pixel_difference(a: &[f32], b: &[f32], head: &[f32]) -> f32 {
    let length = |x: &[f32]| x.iter().map(|x| x * x).sum::<f32>().sqrt() + EPSILON;
    let (of_a, of_b) = (length(a), length(b));
    let channels = a.iter().zip(b).zip(head);
    channels.map(|((a, b), weight)| weight * (a / of_a - b / of_b).powi(2)).sum()
}
