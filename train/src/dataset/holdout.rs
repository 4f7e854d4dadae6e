//! Which images are held out where a dataset has no splits of its own.

use std::path::Path;

use super::{DatasetError, Split};

/// Every N-th image in the order of their names, from the first on, is for test and
/// val; the others train. 0: all train.
#[derive(Clone, Copy, Debug)]
pub(super) struct HoldOut<'f> {
    /// What lists the frames, for messages.
    pub(super) file: &'f Path,
    pub(super) every: u32,
}

/// The frames of a split.
pub(super) fn kept<T>(
    frames: Vec<T>,
    split: Split,
    hold_out: HoldOut<'_>,
) -> Result<Vec<T>, DatasetError> {
    let (n, every) = (frames.len(), hold_out.every as usize);
    let wanted = split != Split::Train;
    let is_held_out = |i: usize| every > 0 && i.is_multiple_of(every);
    let of_split = frames.into_iter().enumerate().filter(|(i, _)| is_held_out(*i) == wanted);
    let kept: Vec<T> = of_split.map(|(_, frame)| frame).collect();
    if kept.is_empty() {
        let (file, split) = (hold_out.file.to_owned(), split.name());
        let why = match every {
            0 => format!("none of its {n} images is held out (--hold-every 0)"),
            _ => format!("it has {n}, of which one in {every} is held out (--hold-every {every})"),
        };
        return Err(DatasetError::EmptySplit { file, split, why });
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_every_eighth_are_held_out() {
        let of =
            |split, every| kept((0..20).collect(), split, HoldOut { file: Path::new("d"), every });
        assert_eq!(of(Split::Test, 8).unwrap(), [0, 8, 16]);
        assert_eq!(of(Split::Val, 8).unwrap(), [0, 8, 16]);
        let train = of(Split::Train, 8).unwrap();
        assert_eq!((train.len(), &train[..8]), (17, &[1, 2, 3, 4, 5, 6, 7, 9][..]));
        assert_eq!(of(Split::Train, 0).unwrap().len(), 20);
        assert_eq!(
            of(Split::Test, 0).unwrap_err().to_string(),
            "d: no test images: none of its 20 images is held out (--hold-every 0)"
        );
        assert_eq!(
            of(Split::Train, 1).unwrap_err().to_string(),
            "d: no train images: it has 20, of which one in 1 is held out (--hold-every 1)"
        );
    }
}
