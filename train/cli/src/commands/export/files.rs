//! Files of meshes.

use std::path::{Path, PathBuf};

use pocketnerf_formats::World;
use pocketnerf_train::surface::{Mesh, Texture, file};

use crate::commands::Failure;

/// A format of meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    Glb,
    Ply,
    Obj,
}

impl Format {
    /// By the file's name.
    pub(super) fn of(path: &Path) -> Result<Self, Failure> {
        Ok(match Self::expect(path, &["glb", "ply", "obj"])?.as_str() {
            "glb" => Self::Glb,
            "ply" => Self::Ply,
            _ => Self::Obj,
        })
    }

    /// The ending of the file's name, if it is one of these.
    pub(super) fn expect(path: &Path, known: &[&str]) -> Result<String, Failure> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let ending = ending.unwrap_or_default();
        if known.contains(&ending.as_str()) {
            return Ok(ending);
        }
        let known: Vec<String> = known.iter().map(|ending| format!(".{ending}")).collect();
        let expected = known.join(", ");
        Err(format!("{}: the file's name ends in {ending:?}, expected {expected}", path.display())
            .into())
    }

    /// What is written beside a mesh with a texture, by the names that the files have for each other:
    /// an OBJ file's materials and image.
    pub(super) fn beside(self, path: &Path) -> Option<[String; 2]> {
        // Programs split names at spaces, and lines at a number sign.
        let safe = |c: char| if c.is_whitespace() || c == '#' { '_' } else { c };
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let stem: String = stem.chars().map(safe).collect();
        (self == Self::Obj).then(|| ["mtl", "png"].map(|ending| format!("{stem}.{ending}")))
    }

    /// The files of a mesh, the one at `path` last: it names the others.
    pub(super) fn write(
        self,
        path: &Path,
        mesh: &Mesh,
        texture: Option<&Texture>,
        world: &World,
    ) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
        let png = texture.map(Texture::png).transpose()?;
        let textured = texture.zip(png);
        let mut files = Vec::new();
        let bytes = match self {
            Self::Ply => file::ply(mesh),
            Self::Glb => file::glb(mesh, textured.as_ref().map(|(t, png)| (*t, &png[..])), world),
            Self::Obj => match (textured, self.beside(path)) {
                (Some((texture, png)), Some([materials, image])) => {
                    let obj = file::obj(mesh, Some((texture, &materials)));
                    files.push((path.with_file_name(&image), png));
                    files.push((path.with_file_name(materials), file::mtl(&image)));
                    obj
                }
                _ => file::obj(mesh, None),
            },
        };
        files.push((path.to_owned(), bytes));
        Ok(files)
    }
}
