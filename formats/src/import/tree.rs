//! What a checkpoint holds, by name.

use std::borrow::Cow;
use std::string::String;
use std::vec::Vec;

use super::ImportError;
use super::error::shown;
use super::tensor::Tensor;

/// One end of the tree.
#[derive(Clone, Debug)]
pub(super) enum Leaf<'a> {
    Tensor(Tensor<'a>),
    Number(f64),
    Text(Cow<'a, str>),
}

/// Names and what they stand for, in the order of the file.
#[derive(Clone, Debug)]
pub(super) struct Tree<'a> {
    leaves: Vec<(String, Leaf<'a>)>,
    /// Indices of `leaves`, ordered by name.
    by_name: Vec<usize>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(leaves: Vec<(String, Leaf<'a>)>) -> Result<Self, ImportError> {
        let mut by_name: Vec<usize> = (0..leaves.len()).collect();
        by_name.sort_unstable_by(|&a, &b| leaves[a].0.cmp(&leaves[b].0));
        match by_name.windows(2).find(|pair| leaves[pair[0]].0 == leaves[pair[1]].0) {
            Some(pair) => Err(ImportError::Duplicate(shown(&leaves[pair[0]].0))),
            None => Ok(Self { leaves, by_name }),
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&str, &Leaf<'a>)> {
        self.leaves.iter().map(|(name, leaf)| (name.as_str(), leaf))
    }

    pub(super) fn get(&self, name: &str) -> Option<&Leaf<'a>> {
        let found = self.by_name.binary_search_by(|&i| self.leaves[i].0.as_str().cmp(name)).ok()?;
        Some(&self.leaves[self.by_name[found]].1)
    }
}
