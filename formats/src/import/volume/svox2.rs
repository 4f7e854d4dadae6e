//! Plenoxels as svox2 saves them (Fridovich-Keil et al. 2022): `SparseGrid.save`.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use half::f16;

use crate::import::settings::{Settings, setting};
use crate::import::tensors::{shape, values};
use crate::import::{Checkpoint, FieldError};

/// What `basis_type` says of spherical harmonics.
const SPHERICAL_HARMONICS: f64 = 1.0;
/// Most voxels along an axis.
const MOST: usize = 1024;
/// Harmonics of a colour, by their degree.
const HARMONICS: [usize; 3] = [1, 4, 9];

/// A sparse grid of densities and spherical harmonics. In its world the corner of voxel `g` lies
/// at `center + radius * ((2 * g + 1) / sizes - 1)`.
#[derive(Clone, Debug)]
pub struct Svox2 {
    /// The middle of the grid.
    pub center: [f32; 3],
    /// Half its sides.
    pub radius: [f32; 3],
    /// Corners along x, y and z, at least 2.
    pub sizes: [usize; 3],
    /// Which row of the others a corner has, z running fastest; negative: it is empty.
    pub links: Vec<i32>,
    /// What is below 0 counts as 0.
    pub densities: Vec<f32>,
    /// `3 * n_harmonics` a row: those of red, then of green, then of blue. A colour is 0.5 more
    /// than their sum; below 0 it counts as 0.
    pub harmonics: Vec<f16>,
    /// Of a colour: 1, 4 or 9.
    pub n_harmonics: usize,
}

impl Svox2 {
    /// Whether a checkpoint has this program's tensors.
    #[must_use]
    pub fn recognises(checkpoint: &Checkpoint<'_>) -> bool {
        ["links", "density_data", "sh_data"].iter().all(|name| checkpoint.tensor(name).is_some())
    }

    /// Takes the grid from a checkpoint.
    ///
    /// # Errors
    /// See [`FieldError`]: backgrounds of spheres and learned bases among them.
    pub fn read(checkpoint: &Checkpoint<'_>) -> Result<Self, FieldError> {
        let settings = Settings(checkpoint);
        if checkpoint.tensor("background_data").is_some() {
            let expected = "none: a scene within the grid";
            return Err(setting("background_data", "spheres around the scene", expected));
        }
        if let Some(basis) = checkpoint.tensor("basis_type") {
            let found = values("basis_type", basis)?;
            if found.iter().any(|found| f64::from(*found) != SPHERICAL_HARMONICS) {
                let expected = "1, spherical harmonics";
                return Err(setting("basis_type", &format!("{found:?}"), expected));
            }
        }
        let vector = |name: &str, default: f32| -> Result<[f32; 3], FieldError> {
            let Some(tensor) = checkpoint.tensor(name) else { return Ok([default; 3]) };
            let found = values(name, tensor)?;
            <[f32; 3]>::try_from(&found[..])
                .map_err(|_| setting(name, &format!("{} numbers", found.len()), "3 numbers"))
        };
        let (radius, center) = (vector("radius", 1.0)?, vector("center", 0.0)?);
        if !radius.iter().all(|radius| (1e-4..1e4).contains(radius)) {
            return Err(setting("radius", &format!("{radius:?}"), "0.0001 to 10000"));
        }
        let wrong = |name: &str, tensor, expected: &str| {
            shape(name.to_string(), tensor, expected.to_string())
        };
        let links = settings.tensor("links")?;
        let sizes = match links.shape() {
            &[x, y, z] if [x, y, z].iter().all(|n| (2..=MOST).contains(n)) => [x, y, z],
            _ => return Err(wrong("links", links, "three sizes from 2 to 1024")),
        };
        let densities = settings.tensor("density_data")?;
        let &[rows, 1] = densities.shape() else {
            return Err(wrong("density_data", densities, "[N, 1]"));
        };
        let harmonics = settings.tensor("sh_data")?;
        let n_harmonics = match harmonics.shape() {
            &[n, columns]
                if n == rows && HARMONICS.contains(&(columns / 3)) && columns % 3 == 0 =>
            {
                columns / 3
            }
            _ => return Err(wrong("sh_data", harmonics, &format!("[{rows}, 3, 12 or 27]"))),
        };
        let read = |name: &str, error| FieldError::Tensor(name.to_string(), error);
        let links = links.to_i32().map_err(|error| read("links", error))?;
        if let Some(beyond) = links.iter().find(|link| **link >= 0 && **link as usize >= rows) {
            let expected = format!("rows of density_data, less than {rows}");
            return Err(setting("links", &beyond.to_string(), &expected));
        }
        let harmonics = harmonics.to_f16().map_err(|error| read("sh_data", error))?;
        if !harmonics.iter().all(|value| value.is_finite()) {
            return Err(FieldError::NotFinite("sh_data".to_string()));
        }
        let densities = values("density_data", densities)?;
        Ok(Self { center, radius, sizes, links, densities, harmonics, n_harmonics })
    }
}
