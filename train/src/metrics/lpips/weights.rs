//! From a file's tensors to a network's weights.

use std::path::Path;

use pocketnerf_formats::import::{Checkpoint, Tensor};

use super::features::{SCALE, SHIFT};
use super::network::{Network, Shape};
use super::{Lpips, LpipsError};

/// A convolution's numbers.
#[derive(Debug)]
pub(super) struct Convolution {
    /// Height, width, channels in, channels out, the last running fastest.
    pub(super) kernel: Vec<f32>,
    /// One for each channel out.
    pub(super) bias: Vec<f32>,
}

/// A file and its tensors, told apart by their shapes, each kind in the order of the names.
struct Weights<'c> {
    file: &'c Path,
    kernels: Vec<Named<'c>>,
    biases: Vec<Named<'c>>,
    heads: Vec<Named<'c>>,
}

type Named<'c> = (&'c str, &'c Tensor<'c>);

/// The weights of whichever network they are.
pub(super) fn read(checkpoint: &Checkpoint<'_>, file: &Path) -> Result<Lpips, LpipsError> {
    let weights = Weights::new(checkpoint, file)?;
    let found = weights.kernels.len();
    let is_it = |network: &&&Network| network.shapes().count() == found;
    let kinds = "5 (AlexNet) or 13 (VGG16)";
    let network = Network::ALL.iter().find(is_it);
    let network = network.ok_or_else(|| weights.count("kernels of convolutions", found, kinds))?;
    if weights.biases.len() != found {
        return Err(weights.count(
            "biases of convolutions",
            weights.biases.len(),
            "as many as kernels",
        ));
    }
    let convolutions = network.shapes().zip(weights.kernels.iter().zip(&weights.biases));
    let convolutions = convolutions.map(|(shape, (kernel, bias))| {
        let kernel = weights.kernel(*kernel, &shape)?;
        let bias =
            weights.numbers(*bias, bias.1.shape() == [shape.to], || format!("[{}]", shape.to))?;
        Ok(Convolution { kernel, bias })
    });
    let convolutions = convolutions.collect::<Result<_, _>>()?;
    Ok(Lpips { network, convolutions, heads: weights.heads(network)? })
}

impl<'c> Weights<'c> {
    fn new(checkpoint: &'c Checkpoint<'_>, file: &'c Path) -> Result<Self, LpipsError> {
        let mut weights = Self { file, kernels: Vec::new(), biases: Vec::new(), heads: Vec::new() };
        let mut tensors: Vec<Named<'c>> =
            checkpoint.names().filter_map(|name| Some((name, checkpoint.tensor(name)?))).collect();
        tensors.sort_by_cached_key(|(name, _)| natural(name));
        for named in tensors {
            match *named.1.shape() {
                // What torch's package keeps beside the weights.
                [1, 3, 1, 1] => weights.check_scaling(named)?,
                [1, 1, _, 1] | [1, _, 1, 1] => weights.heads.push(named),
                [_, _, _, _] => weights.kernels.push(named),
                [_] => weights.biases.push(named),
                _ => return Err(weights.shape(named, "one of a kernel, a bias or a head")),
            }
        }
        Ok(weights)
    }

    /// The heads' numbers. Torch's package has each of them twice, by another name.
    fn heads(&self, network: &Network) -> Result<Vec<Vec<f32>>, LpipsError> {
        let expected = network.taps().count();
        let found = self.heads.len();
        if found != expected && found != 2 * expected {
            return Err(self.count("heads", found, "5"));
        }
        let head = |(named, channels): (&Named<'c>, usize)| {
            let fits = named.1.len() == channels;
            self.numbers(*named, fits, || format!("[1, 1, {channels}, 1] or [1, {channels}, 1, 1]"))
        };
        let read = |heads: &[Named<'c>]| -> Result<Vec<Vec<f32>>, LpipsError> {
            heads.iter().zip(network.taps()).map(head).collect()
        };
        let heads = read(&self.heads[..expected])?;
        if found == 2 * expected {
            let again = read(&self.heads[expected..])?;
            if let Some(i) = (0..expected).find(|&i| heads[i] != again[i]) {
                let name = shown(self.heads[expected + i].0);
                let problem = "is not the same as the head of that number before it";
                return Err(LpipsError::Numbers { file: self.file.to_owned(), name, problem });
            }
        }
        Ok(heads)
    }

    /// A kernel's numbers, turned to the order of [`Convolution`].
    fn kernel(&self, named: Named<'c>, shape: &Shape) -> Result<Vec<f32>, LpipsError> {
        let Shape { side, from, to, .. } = *shape;
        let (ours, torch) = ([side, side, from, to], [to, from, side, side]);
        let found = named.1.shape();
        let fits = found == ours || found == torch;
        let values = self.numbers(named, fits, || format!("{ours:?} or {torch:?}"))?;
        if found == ours {
            return Ok(values);
        }
        let area = side * side;
        let mut turned = Vec::with_capacity(values.len());
        for (at, i) in (0..area).flat_map(|at| (0..from).map(move |i| (at, i))) {
            turned.extend((0..to).map(|o| values[(o * from + i) * area + at]));
        }
        Ok(turned)
    }

    /// The numbers that pictures are made ready with are those that are used here.
    fn check_scaling(&self, named: Named<'c>) -> Result<(), LpipsError> {
        let values = self.numbers(named, true, String::new)?;
        let near = |known: [f32; 3]| values.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-5);
        if near(SHIFT) || near(SCALE) {
            return Ok(());
        }
        let problem = "is neither the shift nor the scale of LPIPS v0.1";
        Err(LpipsError::Numbers { file: self.file.to_owned(), name: shown(named.0), problem })
    }

    /// The numbers of a tensor that has the right shape.
    fn numbers(
        &self,
        named: Named<'c>,
        fits: bool,
        expected: impl FnOnce() -> String,
    ) -> Result<Vec<f32>, LpipsError> {
        if !fits {
            return Err(self.shape(named, &expected()));
        }
        let file = || self.file.to_owned();
        let values = named.1.to_f32();
        let values = values.map_err(|error| LpipsError::Checkpoint { file: file(), error })?;
        if values.iter().all(|value| value.is_finite()) {
            return Ok(values);
        }
        let problem = "holds numbers that are not finite";
        Err(LpipsError::Numbers { file: file(), name: shown(named.0), problem })
    }

    fn count(&self, kind: &'static str, found: usize, expected: &'static str) -> LpipsError {
        LpipsError::Count { file: self.file.to_owned(), kind, found, expected }
    }

    fn shape(&self, (name, tensor): Named<'c>, expected: &str) -> LpipsError {
        LpipsError::Shape {
            file: self.file.to_owned(),
            name: shown(name),
            found: tensor.shape().to_vec(),
            expected: expected.to_owned(),
        }
    }
}

/// A name from a file, fit for one line.
fn shown(name: &str) -> String {
    name.chars().take(80).flat_map(char::escape_debug).collect()
}

/// What orders names as people do: 2 before 10.
fn natural(name: &str) -> Vec<(&str, u64)> {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
        let (text, after) = rest.split_at(digits);
        let end = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
        parts.push((text, after[..end].parse().unwrap_or(u64::MAX)));
        rest = &after[end..];
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_are_numbers() {
        let mut names = ["Conv_10/bias", "Conv_9/bias", "lins.0.w", "lin4.w", "Conv_9/kernel", "é"];
        names.sort_by_key(|name| natural(name));
        let sorted = ["Conv_9/bias", "Conv_9/kernel", "Conv_10/bias", "lin4.w", "lins.0.w", "é"];
        assert_eq!(names, sorted);
        assert_eq!(natural("a99999999999999999999"), [("a", u64::MAX)]);
    }
}
