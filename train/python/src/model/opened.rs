//! A model file in memory.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;

use pocketnerf_core::{Camera, Space};
use pocketnerf_formats::{
    FormatError, ModelFile, PixelOrigin, is_packed, open, open_verified, unpacked, unpacked_len,
};
use pocketnerf_train::picture::Antialias;
use pyo3::prelude::*;
use self_cell::self_cell;

use super::SIDE;
use crate::errors::ModelError;

/// The largest file that is unpacked, far larger than any model.
const MOST_BYTES: u64 = 1 << 30;

self_cell!(
    /// A file with the memory that it borrows.
    struct Cell {
        owner: Memory,
        #[covariant]
        dependent: ModelFile,
    }

    impl {Debug}
);

struct Memory {
    /// Unpacked.
    bytes: Vec<u8>,
    /// As it was given, where that was packed.
    packed: Option<Vec<u8>>,
    /// The empty-space skip table.
    table: Vec<u8>,
}

impl fmt::Debug for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes", self.bytes.len())
    }
}

/// An open model file.
#[derive(Debug)]
pub(crate) struct Opened(Cell);

impl Opened {
    /// Opens the file with these bytes, which errors name.
    pub(super) fn new(bytes: Vec<u8>, name: Option<&Path>) -> PyResult<Self> {
        let refused = |error: &dyn fmt::Display| {
            ModelError::new_err(match name {
                Some(name) => format!("{}: {error}", name.display()),
                None => error.to_string(),
            })
        };
        let (bytes, packed) = match is_packed(&bytes).unwrap_or(false) {
            false => (bytes, None),
            true => {
                let length = unpacked_len(&bytes).map_err(|error| refused(&error))?;
                if length > MOST_BYTES {
                    let found = format!("unpacks to {length} bytes, expected at most {MOST_BYTES}");
                    return Err(refused(&found));
                }
                match unpacked(&bytes).map_err(|error| refused(&error))? {
                    Cow::Owned(unpacked) => (unpacked, Some(bytes)),
                    Cow::Borrowed(_) => (bytes, None),
                }
            }
        };
        let table = table(&bytes).map_err(|error| refused(&error))?;
        let cell = Cell::try_new(Memory { bytes, packed, table }, |memory| {
            let mut file = open(&memory.bytes)?;
            if let Some(occupancy) = &mut file.model.occupancy {
                *occupancy = occupancy.with_table(&memory.table)?;
            }
            Ok::<_, FormatError>(file)
        });
        cell.map(Self).map_err(|error| refused(&error))
    }

    pub(crate) fn file(&self) -> &ModelFile<'_> {
        self.0.borrow_dependent()
    }

    /// The bytes of the file as it was given.
    pub(crate) fn stored(&self) -> &[u8] {
        let memory = self.0.borrow_owner();
        memory.packed.as_deref().unwrap_or(&memory.bytes)
    }

    /// The camera that shows the model first, in the dataset's coordinates.
    pub(super) fn camera(&self) -> Camera {
        let file = self.file();
        let [width, height] =
            file.about.camera.map_or([SIDE; 2], |camera| [camera.width, camera.height]);
        file.about.scene.camera_to_dataset(&file.camera(width, height))
    }

    /// Where photographs were taken, in the dataset's coordinates.
    pub(super) fn photographs(&self) -> Vec<Camera> {
        let file = self.file();
        let Some(photographs) = file.about.photographs else { return Vec::new() };
        let own = self.camera();
        let fov_x = 2.0 * (0.5 / photographs.focal).atan();
        let camera = |pose| Camera::from_fov_x(own.width, own.height, fov_x, pose);
        let cameras = photographs.poses().map(camera);
        cameras.map(|camera| file.about.scene.camera_to_dataset(&camera)).collect()
    }

    /// A camera in the dataset's coordinates as the model's, whose rays pass through pixels where
    /// the model expects them.
    pub(super) fn to_model(&self, camera: &Camera, antialias: Antialias) -> Camera {
        let about = &self.file().about;
        let mut camera = about.scene.camera_to_model(camera);
        if about.pixel_origin == PixelOrigin::Corner {
            let n = antialias.rays(&camera);
            camera.center = camera.center.map(|c| c + 0.5 / n as f32);
        }
        camera
    }

    /// The box around the scene, in the dataset's coordinates, smallest and largest corner.
    pub(super) fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let file = self.file();
        let Space::Box { min, max } = file.model.space else { return None };
        let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 1 { max[a] } else { min[a] });
        let corners = (0..8).map(|i| file.about.scene.to_dataset(corner(i)));
        let start = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        Some(corners.fold(start, |[low, high], p| {
            [[0, 1, 2].map(|a| low[a].min(p[a])), [0, 1, 2].map(|a| high[a].max(p[a]))]
        }))
    }

    /// The middle of the scene, and how far a camera around it is, in the dataset's coordinates.
    pub(super) fn center(&self) -> PyResult<([f32; 3], f32)> {
        let file = self.file();
        if matches!(file.model.space, Space::Ndc(_)) {
            return Err(ModelError::new_err(
                "a forward-facing capture has no sides to go around; give a Camera",
            ));
        }
        let (space, scene) = (&file.model.space, &file.about.scene);
        Ok((scene.to_dataset(space.center()), scene.scale * space.viewing_distance()))
    }
}

/// The empty-space skip table of the file with these bytes, all of which are checked.
fn table(bytes: &[u8]) -> Result<Vec<u8>, FormatError> {
    let file = open_verified(bytes)?;
    let mut table = vec![0; file.model.table_len()];
    if let Some(occupancy) = &file.model.occupancy {
        occupancy.write_table(&mut table)?;
    }
    Ok(table)
}
