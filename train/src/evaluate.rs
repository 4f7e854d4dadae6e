//! A model against the views of a dataset.

use std::borrow::Cow;
use std::time::Instant;

use pocketnerf_core::{Error, Model};
use serde::Serialize;

use crate::dataset::Dataset;
use crate::{metrics, picture};

/// One view's result.
#[derive(Clone, Debug, Serialize)]
pub struct ViewScore {
    /// The view's name.
    pub name: String,
    /// dB, on 8-bit values; `null` for identical pictures.
    pub psnr: f64,
    /// Structural similarity; `null` where the picture is too small.
    pub ssim: Option<f64>,
}

/// Results over a split.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Number of views.
    pub views: usize,
    /// Picture width of the first view.
    pub width: u32,
    /// Picture height of the first view.
    pub height: u32,
    /// What the pictures and the truth were composited on.
    pub background: [f32; 3],
    /// Mean of the views' PSNR, dB.
    pub psnr: f64,
    /// Mean of the views' SSIM.
    pub ssim: Option<f64>,
    /// Not measured: no weights given.
    pub lpips: Option<f64>,
    /// Every view.
    pub per_view: Vec<ViewScore>,
    /// Median rendering time.
    pub seconds_per_frame: f64,
    /// Its inverse.
    pub frames_per_second: f64,
    /// Pixels a second, interpolated ones too.
    pub rays_per_second: f64,
    /// Samples at which the field was asked, a pixel.
    pub samples_per_ray: f64,
    /// Threads that rendered.
    pub threads: usize,
}

/// What a mask leaves: of picture and truth the pixels that count, one after another,
/// and the picture with the truth in place of the others.
fn masked<'p>(
    picture: &'p [u8],
    truth: &'p [u8],
    mask: Option<&[u8]>,
) -> ([Cow<'p, [u8]>; 2], Cow<'p, [u8]>) {
    let Some(mask) = mask else { return ([picture.into(), truth.into()], picture.into()) };
    let counted = |rgb: &[u8]| {
        let pixels = rgb.as_chunks::<3>().0.iter().zip(mask).filter(|(_, counts)| **counts != 0);
        pixels.flat_map(|(pixel, _)| *pixel).collect::<Vec<u8>>().into()
    };
    let mut without = picture.to_vec();
    let pixels = without.as_chunks_mut::<3>().0.iter_mut().zip(truth.as_chunks::<3>().0);
    let ignored = pixels.zip(mask).filter(|(_, counts)| **counts == 0);
    ignored.for_each(|((ours, theirs), _)| *ours = *theirs);
    ([counted(picture), counted(truth)], without.into())
}

/// Renders every view and compares; `each` receives the view's number, its
/// 8-bit picture and the 8-bit truth.
///
/// Pixels that a view's mask ignores do not count for PSNR; for SSIM, whose windows
/// reach across the mask's edge, the picture is right there by definition.
///
/// # Errors
/// Whatever rendering reports.
pub fn evaluate(
    model: &Model<'_>,
    dataset: &Dataset,
    background: [f32; 3],
    settings: &picture::Settings,
    mut each: impl FnMut(usize, &[u8], &[u8]),
) -> Result<Evaluation, Error> {
    let (mut times, mut per_view, mut rays, mut samples) = (Vec::new(), Vec::new(), 0, 0);
    let mut renderer = picture::Renderer::new(model, settings);
    for (i, view) in dataset.views.iter().enumerate() {
        let begun = Instant::now();
        let rendered = renderer.render_through(&view.camera, &view.lens)?;
        times.push(begun.elapsed().as_secs_f64());
        rays += u64::from(rendered.width) * u64::from(rendered.height);
        samples += rendered.stats.samples;
        let picture = metrics::quantize_all(&rendered.over(background));
        let truth = metrics::quantize_all(&metrics::composite_on(&view.rgba, background));
        let size = (view.camera.width as usize, view.camera.height as usize);
        let (counted, without) = masked(&picture, &truth, view.mask.as_deref());
        per_view.push(ViewScore {
            name: view.name.clone(),
            psnr: metrics::psnr(&counted[0], &counted[1]),
            ssim: metrics::ssim(&without, &truth, size.0, size.1),
        });
        each(i, &picture, &truth);
    }
    let n = per_view.len().max(1) as f64;
    let total: f64 = times.iter().sum();
    times.sort_by(f64::total_cmp);
    let median = times.get(times.len() / 2).copied().unwrap_or(0.0);
    let ssim: Option<f64> = per_view.iter().map(|v| v.ssim).sum();
    let first = dataset.views.first().map_or([0, 0], |v| [v.camera.width, v.camera.height]);
    Ok(Evaluation {
        views: per_view.len(),
        width: first[0],
        height: first[1],
        background,
        psnr: per_view.iter().map(|v| v.psnr).sum::<f64>() / n,
        ssim: ssim.map(|sum| sum / n),
        lpips: None,
        per_view,
        seconds_per_frame: median,
        frames_per_second: 1.0 / median.max(1e-9),
        rays_per_second: rays as f64 / total.max(1e-9),
        samples_per_ray: samples as f64 / (rays as f64).max(1.0),
        threads: rayon::current_num_threads(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_pixels_count_for_nothing() {
        // Three pixels, of which the second is ignored.
        let (ours, truth) = ([0, 51, 0, 200, 200, 200, 9, 9, 9], [0, 0, 0, 1, 2, 3, 9, 9, 9]);
        let ([picture, photograph], without) = masked(&ours, &truth, Some(&[255, 0, 1]));
        assert_eq!(*picture, [0, 51, 0, 9, 9, 9]);
        assert_eq!(*photograph, [0, 0, 0, 9, 9, 9]);
        assert_eq!(*without, [0, 51, 0, 1, 2, 3, 9, 9, 9]);
        // One value of six differs by 0.2: the mean square is 0.04 / 6, 21.76 dB.
        let expected = -10.0 * (0.04f64 / 6.0).log10();
        assert!((metrics::psnr(&picture, &photograph) - expected).abs() < 1e-9);
        let ([picture, _], without) = masked(&ours, &truth, None);
        assert_eq!((&*picture, &*without), (&ours[..], &ours[..]));
    }
}
