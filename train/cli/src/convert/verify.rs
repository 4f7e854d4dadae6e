//! Compares source and result on the same rays.

use pocketnerf_core::{Camera, ColorSpace, Error, Model};
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::{Painter, Picture, Renderer, Sampling, Settings};
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

/// Takes the pictures of both, in these colour spaces, over one background (sRGB), and compares
/// them in sRGB.
///
/// # Errors
/// Whatever rendering reports.
pub fn compare(
    [first, second]: [(&mut dyn Painter, ColorSpace); 2],
    background: [f32; 3],
    cameras: &[Camera],
) -> Result<Difference, Error> {
    let (mut squares, mut values, mut max_error) = (0.0, 0usize, 0.0f32);
    let (mut samples, mut pixels) = ([0.0; 2], 0.0);
    for camera in cameras {
        let a = first.0.paint(camera, &Lens::Pinhole)?;
        let b = second.0.paint(camera, &Lens::Pinhole)?;
        samples[0] += a.stats.samples as f64;
        samples[1] += b.stats.samples as f64;
        pixels += f64::from(a.width) * f64::from(a.height);
        let (a, b) = (in_srgb(a, first.1, background), in_srgb(b, second.1, background));
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

/// Compares the pictures of two models, each with its own sampling, over the first one's background.
///
/// # Errors
/// Whatever rendering reports.
pub fn compare_models(
    models: [(&Model<'_>, Sampling); 2],
    cameras: &[Camera],
    settings: &Settings,
) -> Result<Difference, Error> {
    let background = models[0].0.display.srgb_background();
    let settings = models.map(|(_, sampling)| Settings { sampling, ..*settings });
    let [mut first, mut second] = [0, 1].map(|i| Renderer::new(models[i].0, &settings[i]));
    let [a, b] = models.map(|(model, _)| model.display.color_space);
    compare([(&mut first, a), (&mut second, b)], background, cameras)
}

/// The picture of a model of this colour space over an sRGB background.
fn in_srgb(picture: &Picture, space: ColorSpace, background: [f32; 3]) -> Vec<f32> {
    let rgb = picture.over(space.from_srgb(background));
    rgb.as_chunks::<3>().0.iter().flat_map(|rgb| space.to_srgb(*rgb)).collect()
}
