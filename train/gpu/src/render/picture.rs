//! What a GPU renders.

/// A rendered picture, in the model's colour space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels along x.
    pub width: u32,
    /// Pixels along y.
    pub height: u32,
    /// Premultiplied RGBA without background, four values a pixel, row after row.
    pub rgba: Vec<f32>,
    /// Expected Euclidean distance of each pixel, scene units; infinite where nothing is.
    pub depth: Vec<f32>,
    /// Samples at which the field was evaluated.
    pub samples: u64,
    /// Rays with any such sample.
    pub hits: u64,
}
