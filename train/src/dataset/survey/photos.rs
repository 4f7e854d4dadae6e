//! The photographs of a survey, found by their names wherever they lie.

use std::collections::HashMap;
use std::path::Path;

use crate::dataset::images;

/// Folders inside folders are searched so deep.
const DEEPEST: usize = 4;
/// Folders whose images are no photographs.
const OTHERS: [&str; 3] = ["masks", "depth", "thumbnails"];

/// Where the photographs of a folder are, by their names and their names without ending.
pub(super) struct Photos {
    paths: HashMap<String, Place>,
}

enum Place {
    At(String),
    /// Two of one name.
    Several([String; 2]),
}

impl Photos {
    /// Those in the folder itself come first, then those in `images`, then those deeper inside.
    pub(super) fn new(folder: &Path) -> Self {
        let mut photos = Self { paths: HashMap::new() };
        let mut level = vec![String::new()];
        for depth in 0..=DEEPEST {
            let (mut found, mut next) = (Vec::new(), Vec::new());
            for inside in &level {
                let at = folder.join(inside);
                let names = images::names(&at, &images::EXTENSIONS).unwrap_or_default();
                found.extend(names.into_iter().map(|name| (inside.clone(), name)));
                next.extend(folders(&at, depth == 0).into_iter().map(|name| join(inside, &name)));
            }
            if depth == 1 {
                let (own, others) = found.into_iter().partition(|(inside, _)| inside == "images");
                photos.add(own);
                found = others;
            }
            photos.add(found);
            level = next;
        }
        photos
    }

    /// The photograph that a camera names: a path of which only the last part counts, with or
    /// without an ending. `None`: there is none; an error says that there are several.
    pub(super) fn find(&self, label: &str) -> Result<Option<&str>, String> {
        let name = label.rsplit(['/', '\\']).next().unwrap_or(label).trim().to_lowercase();
        let place = self.paths.get(&name).or_else(|| self.paths.get(stem(&name)));
        match place {
            None => Ok(None),
            Some(Place::At(path)) => Ok(Some(path)),
            Some(Place::Several([first, second])) => Err(format!(
                "\"{label}\" may be {first} or {second}, expected one photograph of that name"
            )),
        }
    }

    /// Adds the photographs of a level; those of earlier ones stay.
    fn add(&mut self, found: Vec<(String, String)>) {
        let mut own: HashMap<String, Place> = HashMap::new();
        for (inside, name) in found {
            let path = join(&inside, &name);
            let name = name.to_lowercase();
            for key in [stem(&name).to_owned(), name] {
                let place = match own.remove(&key) {
                    None => Place::At(path.clone()),
                    Some(Place::At(first)) if first != path => {
                        Place::Several([first, path.clone()])
                    }
                    Some(place) => place,
                };
                own.insert(key, place);
            }
        }
        for (key, place) in own {
            self.paths.entry(key).or_insert(place);
        }
    }
}

/// The folders in one, sorted. Links may lead in circles and are followed only if asked for.
fn folders(folder: &Path, follow: bool) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_folder = |entry: &std::fs::DirEntry| match follow {
        true => entry.path().is_dir(),
        false => entry.file_type().is_ok_and(|kind| kind.is_dir()),
    };
    let folders = entries.filter(is_folder);
    let names = folders.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let is_hidden = |name: &String| name.starts_with('.') || OTHERS.contains(&name.as_str());
    let mut names: Vec<String> = names.filter(|name| !is_hidden(name)).collect();
    names.sort();
    names
}

fn join(inside: &str, name: &str) -> String {
    if inside.is_empty() { name.to_owned() } else { format!("{inside}/{name}") }
}

fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photographs_are_found_by_name() {
        let folder = tempfile::tempdir().unwrap();
        for path in ["a.jpg", "images/A.png", "images/b.JPG", "x/c.png", "y/c.png", "masks/d.png"] {
            let file = folder.path().join(path);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, "").unwrap();
        }
        // A linked folder counts; what is linked deeper inside may lead in circles.
        let other = tempfile::tempdir().unwrap();
        std::fs::write(other.path().join("e.jpg"), "").unwrap();
        #[cfg(unix)]
        for (from, to) in [(other.path(), "linked"), (folder.path(), "x/circle")] {
            std::os::unix::fs::symlink(from, folder.path().join(to)).unwrap();
        }
        let photos = Photos::new(folder.path());
        let find = |label| photos.find(label);
        assert_eq!(find("a"), Ok(Some("a.jpg")));
        assert_eq!(find("D:\\flight\\a.png"), Ok(Some("images/A.png")));
        assert_eq!(find("b.tif"), Ok(Some("images/b.JPG")));
        assert_eq!(find("d"), Ok(None));
        assert_eq!(find("e"), Ok(cfg!(unix).then_some("linked/e.jpg")));
        let several = find("c").unwrap_err();
        assert_eq!(
            several,
            "\"c\" may be x/c.png or y/c.png, expected one photograph of that name"
        );
    }
}
