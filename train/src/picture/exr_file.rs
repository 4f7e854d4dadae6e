//! Writes depth and normals as OpenEXR files: 32-bit floats, without loss.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};

use crate::output::{OutputError, write_atomic};

/// Writes depth as channel `Y`, one value a pixel from the top left, as it is: infinite where
/// nothing is. Of a channel `Z` alone, OpenCV, FreeImage and ffmpeg make zeros or noise.
///
/// # Errors
/// One line that names the file.
///
/// # Panics
/// If `depth` does not hold `width * height` values.
pub fn write_depth(path: &Path, width: u32, height: u32, depth: &[f32]) -> Result<(), OutputError> {
    write(path, [width, height], vec![("Y", depth.to_vec())])
}

/// Writes vectors, one a pixel from the top left, as they are: x, y and z as channels `R`, `G`
/// and `B`. OpenCV reads the `Y` of `X`, `Y` and `Z` alone.
///
/// # Errors
/// One line that names the file.
///
/// # Panics
/// If `normals` does not hold `width * height` vectors.
pub fn write_normals(
    path: &Path,
    width: u32,
    height: u32,
    normals: &[[f32; 3]],
) -> Result<(), OutputError> {
    let channel = |axis: usize| normals.iter().map(|normal| normal[axis]).collect();
    let channels = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    write(path, [width, height], channels)
}

fn write(path: &Path, size: [u32; 2], channels: Vec<(&str, Vec<f32>)>) -> Result<(), OutputError> {
    let [width, height] = size.map(|side| side as usize);
    assert!(channels.iter().all(|(_, values)| values.len() == width * height), "a value a pixel");
    let channels = channels
        .into_iter()
        .map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values)))
        .collect();
    let layer = Layer::new(
        (width, height),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels),
    );
    let mut bytes = Cursor::new(Vec::new());
    let refused = |error| OutputError::Refused {
        file: path.to_owned(),
        source: std::io::Error::other(error),
    };
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(refused)?;
    write_atomic(path, bytes.get_ref())
}

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels, ReadLayers, read};

    use super::*;

    /// Names of the channels and their values.
    fn channels(path: &Path) -> Vec<(String, Vec<f32>)> {
        let image = read().no_deep_data().largest_resolution_level().all_channels();
        let image = image.first_valid_layer().all_attributes().from_file(path).unwrap();
        let list = image.layer_data.channel_data.list.into_iter();
        list.map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect())).collect()
    }

    #[test]
    fn numbers_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let depth = [2.5, 1e-9, 1e9, f32::INFINITY, 70_000.3, 0.1];
        write_depth(&path, 3, 2, &depth).unwrap();
        assert_eq!(channels(&path), [("Y".to_owned(), depth.to_vec())]);
        write_normals(&path, 1, 2, &[[0.6, -0.8, 0.0], [0.0, 0.1, 1.0]]).unwrap();
        let expected = [("B", [0.0, 1.0]), ("G", [-0.8, 0.1]), ("R", [0.6, 0.0])];
        assert_eq!(channels(&path), expected.map(|(name, v)| (name.to_owned(), v.to_vec())));
        let colours = crate::picture::image_file::open(&path).unwrap().to_rgb32f();
        assert_eq!(colours.into_raw(), [0.6, -0.8, 0.0, 0.0, 0.1, 1.0]);
    }
}
