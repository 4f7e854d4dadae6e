//! Splits that the file itself lists.

use std::collections::HashSet;

use crate::dataset::listing::{Frame, Listing, relative_path};
use crate::dataset::{DatasetError, Split};

/// Keeps the frames that the lists name for a split. Where only one of val and test is
/// listed, it is both; where train is not, it is all others.
pub(super) fn choose(
    listing: &mut Listing,
    split: Split,
    lists: &[(Split, Vec<String>)],
) -> Result<(), DatasetError> {
    let known: HashSet<String> = {
        let frames = listing.frames.iter().map(|frame| &frame.path);
        let paths = frames.chain(&listing.left_out);
        paths.flat_map(|path| [path.clone(), without_extension(path).to_owned()]).collect()
    };
    let of = |split: Split| lists.iter().find(|(own, _)| *own == split);
    let own = match split {
        Split::Train => of(Split::Train),
        Split::Val => of(Split::Val).or_else(|| of(Split::Test)),
        Split::Test => of(Split::Test).or_else(|| of(Split::Val)),
    };
    let mut named = HashSet::new();
    for (list, names) in own.map_or(lists, std::slice::from_ref) {
        for name in names.iter().map(|name| relative_path(name)) {
            if !known.contains(&name) {
                let (file, list) = (listing.file.clone(), list.name());
                return Err(DatasetError::NoSuchFrame { file, list, name });
            }
            named.insert(name);
        }
    }
    let is_named = |frame: &Frame| {
        named.contains(&frame.path) || named.contains(without_extension(&frame.path))
    };
    match (own, split) {
        (Some(_), _) => listing.frames.retain(is_named),
        (None, Split::Train) => listing.frames.retain(|frame| !is_named(frame)),
        (None, _) => listing.frames.clear(),
    }
    if listing.frames.is_empty() {
        let has: Vec<&str> = lists.iter().map(|(split, _)| split.name()).collect();
        let (file, split) = (listing.file.clone(), split.name());
        let why = format!("it lists {}", has.join(", "));
        return Err(DatasetError::EmptySplit { file, split, why });
    }
    Ok(())
}

/// `images/0001.jpg` without `.jpg`.
fn without_extension(path: &str) -> &str {
    path.rsplit_once('.').filter(|(_, end)| !end.contains('/')).map_or(path, |(stem, _)| stem)
}
