//! Photographs that are there more than once.

use crate::dataset::{Dataset, View};

impl Dataset {
    /// Leaves out views that are equal to an earlier one in camera, lens, mask and every pixel:
    /// they would count as often as they are there. Gives their names.
    pub fn leave_out_duplicates(&mut self) -> Vec<String> {
        let mut kept: Vec<View> = Vec::with_capacity(self.views.len());
        let mut names = Vec::new();
        for view in std::mem::take(&mut self.views) {
            match kept.iter().any(|other| is_same(other, &view)) {
                true => names.push(view.name),
                false => kept.push(view),
            }
        }
        self.views = kept;
        names
    }
}

/// Cameras first: they hardly ever are.
fn is_same(a: &View, b: &View) -> bool {
    (a.camera, a.lens) == (b.camera, b.lens) && a.mask == b.mask && a.rgba == b.rgba
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::dataset::Split;

    #[test]
    fn each_photograph_counts_once() {
        let mut dataset = builtin::dataset(Split::Train, 40);
        let names: Vec<String> = dataset.views.iter().map(|view| view.name.clone()).collect();
        // Another photograph from the same place is no duplicate, nor one from another.
        let [mut brighter, mut moved, again] =
            [3, 4, 5].map(|i| View { name: format!("again/{i}"), ..dataset.views[i].clone() });
        brighter.rgba[0] ^= 1;
        moved.camera.center[0] += 0.5;
        dataset.views.insert(9, again.clone());
        dataset.views.extend([brighter, moved, again]);
        assert_eq!(dataset.leave_out_duplicates(), ["again/5", "again/5"]);
        let left: Vec<&String> = dataset.views.iter().map(|view| &view.name).collect();
        let others = ["again/3".to_owned(), "again/4".to_owned()];
        assert_eq!(left, names.iter().chain(&others).collect::<Vec<_>>());
        assert!(dataset.leave_out_duplicates().is_empty());
    }
}
