//! Binary files of a COLMAP model: little-endian, without padding, a count first.

use glam::{DQuat, DVec3};

use super::camera::{self, Camera};
use super::model::{CAMERA_HINT, File, Image, Point};
use crate::dataset::DatasetError;

/// Bytes of a camera at least: its head and three parameters.
const CAMERA: u64 = 24 + 3 * 8;
/// Bytes of an image at least: its head, the end of its name and a count.
const IMAGE: u64 = 64 + 1 + 8;
/// Bytes of a point in a picture.
const MARK: u64 = 24;
/// Bytes of a 3-D point at least.
const POINT: u64 = 51;
/// Bytes of an image that shows a point.
const TRACK: u64 = 8;

/// What has not been read of a file.
struct Rest<'f> {
    file: &'f File<'f>,
    bytes: &'f [u8],
}

pub(super) fn cameras(file: &File<'_>) -> Result<Vec<(u32, Camera)>, DatasetError> {
    let mut rest = Rest { file, bytes: file.bytes };
    let count = rest.count(CAMERA, "cameras")?;
    let mut cameras = Vec::with_capacity(count);
    for _ in 0..count {
        let (id, number) = (rest.u32()?, rest.u32()?);
        let size = [rest.u64()? as f64, rest.u64()? as f64];
        let Some((kind, parameters)) = camera::kind(number) else {
            return Err(DatasetError::NotReadable {
                file: file.path.to_owned(),
                what: format!("camera {id}, of the model with the number {number},"),
                hint: CAMERA_HINT,
            });
        };
        let numbers = (0..parameters).map(|_| rest.f64()).collect::<Result<Vec<_>, _>>()?;
        let camera = Camera::new(kind, size, &numbers);
        cameras
            .push((id, camera.map_err(|problem| file.wrong(format!("camera {id}: {problem}")))?));
    }
    rest.end("cameras")?;
    Ok(cameras)
}

pub(super) fn images(file: &File<'_>) -> Result<Vec<Image>, DatasetError> {
    let mut rest = Rest { file, bytes: file.bytes };
    let count = rest.count(IMAGE, "images")?;
    let mut images = Vec::with_capacity(count);
    for _ in 0..count {
        let id = rest.u32()?;
        let [w, x, y, z] = [rest.f64()?, rest.f64()?, rest.f64()?, rest.f64()?];
        let translation = rest.point()?;
        let (camera, name) = (rest.u32()?, rest.name()?);
        let marks = rest.count(MARK, "points in an image")?;
        rest.take(marks as u64 * MARK)?;
        let rotation = DQuat::from_xyzw(x, y, z, w);
        images.push(Image::new(file, id, name, camera, (rotation, translation))?);
    }
    rest.end("images")?;
    Ok(images)
}

/// How many images a file announces.
pub(super) fn announced(file: &File<'_>) -> Result<usize, DatasetError> {
    Rest { file, bytes: file.bytes }.count(IMAGE, "images")
}

pub(super) fn points(file: &File<'_>) -> Result<Vec<Point>, DatasetError> {
    let mut rest = Rest { file, bytes: file.bytes };
    let count = rest.count(POINT, "points")?;
    let mut points = Vec::new();
    for _ in 0..count {
        rest.u64()?;
        let at = rest.point()?;
        // Its colour, and how far off pictures show it.
        rest.take(3 + 8)?;
        let seen = rest.count(TRACK, "images of a point")?;
        let images = (0..seen).map(|_| {
            let image = rest.u32()?;
            rest.u32().map(|_| image)
        });
        points.extend(Point::new(at, images.collect::<Result<_, _>>()?));
    }
    rest.end("points")?;
    Ok(points)
}

impl<'f> Rest<'f> {
    fn take(&mut self, bytes: u64) -> Result<&'f [u8], DatasetError> {
        let split = usize::try_from(bytes).ok().and_then(|n| self.bytes.split_at_checked(n));
        let Some((taken, rest)) = split else {
            let (at, left) = (self.file.bytes.len() - self.bytes.len(), self.bytes.len());
            return Err(self.file.wrong(format!(
                "cut off: {left} bytes are left at byte {at}, expected {bytes} or more"
            )));
        };
        self.bytes = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], DatasetError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N as u64)?);
        Ok(array)
    }

    fn u32(&mut self) -> Result<u32, DatasetError> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, DatasetError> {
        self.array().map(u64::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64, DatasetError> {
        self.array().map(f64::from_le_bytes)
    }

    fn point(&mut self) -> Result<DVec3, DatasetError> {
        Ok(DVec3::new(self.f64()?, self.f64()?, self.f64()?))
    }

    /// How many follow, of so many bytes at least.
    fn count(&mut self, bytes: u64, what: &str) -> Result<usize, DatasetError> {
        let (count, left) = (self.u64()?, self.bytes.len() as u64);
        if count > left / bytes {
            return Err(self.file.wrong(format!(
                "{count} {what} are announced, but {left} bytes follow, expected at least {bytes} \
                 for each"
            )));
        }
        Ok(count as usize)
    }

    /// A text that ends with a zero.
    fn name(&mut self) -> Result<&'f str, DatasetError> {
        let Some(len) = self.bytes.iter().position(|byte| *byte == 0) else {
            return Err(self.file.wrong("an image's name has no end, expected a zero".to_owned()));
        };
        let name = self.take(len as u64)?;
        self.take(1)?;
        self.file.text(name)
    }

    /// Refuses what is left over.
    fn end(&self, what: &str) -> Result<(), DatasetError> {
        match self.bytes.len() {
            0 => Ok(()),
            left => Err(self
                .file
                .wrong(format!("{left} bytes follow the last of its {what}, expected none"))),
        }
    }
}
