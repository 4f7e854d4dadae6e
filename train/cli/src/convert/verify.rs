//! Compares source and result on the same rays.

use pocketnerf_core::{Camera, ColorSpace, Error, Model};
use pocketnerf_train::picture::{Picture, Renderer, Sampling, Settings};
use serde::Serialize;

/// How the pictures of two models differ.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Difference {
    /// dB, over all pixels; `null` for equal pictures.
    pub psnr: f64,
    /// The largest difference of a channel, 0 to 1.
    pub max_error: f32,
    /// Evaluations per pixel of the first and of the second model.
    pub evaluations: [f64; 2],
}

/// Renders both models, each with its own sampling, over the first one's background, and
/// compares the pictures in sRGB.
///
/// # Errors
/// Whatever rendering reports.
pub fn compare(
    models: [(&Model<'_>, Sampling); 2],
    cameras: &[Camera],
    settings: &Settings,
) -> Result<Difference, Error> {
    let background = models[0].0.display.srgb_background();
    let [first_space, second_space] = models.map(|(model, _)| model.display.color_space);
    let settings = models.map(|(_, sampling)| Settings { sampling, ..*settings });
    let mut renderers = [0, 1].map(|i| Renderer::new(models[i].0, &settings[i]));
    let (mut squares, mut values, mut max_error) = (0.0, 0usize, 0.0f32);
    let (mut samples, mut pixels) = ([0.0; 2], 0.0);
    for camera in cameras {
        let [first, second] = &mut renderers;
        let (first, second) = (first.render(camera)?, second.render(camera)?);
        samples[0] += first.stats.samples as f64;
        samples[1] += second.stats.samples as f64;
        pixels += f64::from(first.width) * f64::from(first.height);
        let a = in_srgb(first, first_space, background);
        let b = in_srgb(second, second_space, background);
        values += a.len();
        for (a, b) in a.iter().zip(&b) {
            squares += f64::from(a - b).powi(2);
            max_error = max_error.max((a - b).abs());
        }
    }
    Ok(Difference {
        psnr: 10.0 * (values.max(1) as f64 / squares).log10(),
        max_error,
        evaluations: samples.map(|samples| samples / f64::max(pixels, 1.0)),
    })
}

/// The picture of a model of this colour space over an sRGB background.
fn in_srgb(picture: &Picture, space: ColorSpace, background: [f32; 3]) -> Vec<f32> {
    let rgb = picture.over(space.from_srgb(background));
    rgb.as_chunks::<3>().0.iter().flat_map(|rgb| space.to_srgb(*rgb)).collect()
}
