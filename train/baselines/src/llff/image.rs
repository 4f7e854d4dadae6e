//! A multiplane image in 8 bits, packed for its file.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use pocketnerf_core::Camera;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::planes::Planes;
use crate::BaselineError;

/// The camera of an image, and where its planes are.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Shape {
    size: [u32; 2],
    focal: [f32; 2],
    center: [f32; 2],
    camera_to_world: [f32; 16],
    /// Of the first plane and the last.
    depths: [f32; 2],
    planes: u32,
}

/// What is stored of an image.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Packed {
    shape: Shape,
    /// sRGB and opacity of each plane, eight bits each, deflated.
    planes: Vec<Vec<u8>>,
}

/// An image to render.
#[derive(Debug)]
pub(super) struct Image {
    pub(super) planes: Planes,
    pub(super) values: Vec<Vec<[u8; 4]>>,
}

impl Shape {
    pub(super) fn new(camera: &Camera, depths: [f32; 2], planes: usize) -> Self {
        let Camera { width, height, focal, center, camera_to_world } = *camera;
        Self {
            size: [width, height],
            focal,
            center,
            camera_to_world,
            depths,
            planes: planes as u32,
        }
    }

    pub(super) fn camera(&self) -> Camera {
        let Self { size: [width, height], focal, center, camera_to_world, .. } = *self;
        Camera { width, height, focal, center, camera_to_world }
    }

    pub(super) fn planes(&self) -> Planes {
        Planes::new(self.camera(), self.planes as usize, self.depths)
    }

    pub(super) fn is_sound(&self) -> bool {
        let [near, far] = self.depths;
        let planes = (2..=MOST_PLANES).contains(&self.planes);
        planes && self.camera().validate().is_ok() && near > 0.0 && far > near && far.is_finite()
    }
}

impl Packed {
    pub(super) fn new<'v>(
        shape: Shape,
        values: impl IndexedParallelIterator<Item = &'v [[f32; 4]]>,
    ) -> Self {
        let pack = |values: &[[f32; 4]]| {
            let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            let bytes = values.iter().flat_map(|value| {
                let [r, g, b, opacity] = value.map(byte);
                // Colours of what is not there take no room.
                if opacity == 0 { [0; 4] } else { [r, g, b, opacity] }
            });
            deflated(&bytes.collect::<Vec<u8>>())
        };
        Self { shape, planes: values.map(pack).collect() }
    }

    pub(super) fn camera(&self) -> Camera {
        self.shape.camera()
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.planes.iter().map(Vec::len).sum()
    }

    /// Values that it holds.
    pub(super) fn values(&self) -> usize {
        4 * self.planes.len() * self.shape.size[0] as usize * self.shape.size[1] as usize
    }

    pub(super) fn is_sound(&self) -> bool {
        self.shape.is_sound() && self.planes.len() == self.shape.planes as usize
    }

    /// The image itself.
    pub(super) fn unpacked(&self) -> Result<Image, BaselineError> {
        let planes = self.shape.planes();
        let length = 4 * planes.pixels();
        let unpack = |packed: &Vec<u8>| {
            let mut bytes = Vec::new();
            let read =
                ZlibDecoder::new(&packed[..]).take(length as u64 + 1).read_to_end(&mut bytes);
            match read {
                Ok(read) if read == length => Ok(bytes.as_chunks::<4>().0.to_vec()),
                _ => Err(BaselineError::Damaged("a plane is not as large as its image")),
            }
        };
        let values = self.planes.par_iter().map(unpack).collect::<Result<_, _>>()?;
        Ok(Image { planes, values })
    }
}

/// Planes that a file may have.
const MOST_PLANES: u32 = 512;

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    // Memory does not refuse to be written to.
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.unwrap_or_default()
}
