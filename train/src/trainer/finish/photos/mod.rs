//! Photographs that do not agree with the model, or with each other.
//!
//! A field that was shown contradictions learns their mean, and training's PSNR does not say why
//! it is low. What is wrong can be told from the pictures: cameras that are not where they should
//! be see the model shifted, exposures that change see it brighter or darker, and a photograph of
//! something else has an error like no other.

mod compare;

use pocketnerf_core::{Camera, Error};
use rayon::prelude::*;

use super::Finished;
use crate::metrics::{composite_on, quantile};
use crate::picture::{Renderer, Settings};
use crate::trainer::Trainer;
use crate::trainer::pixels::rays::{Pixel, RaySource};
use compare::{Look, compare};

/// Views that are looked at, at most, evenly spread.
const VIEWS: usize = 64;
/// Pixels along a side of the middle of a view that is looked at.
const SIDE: u32 = 96;
/// A photograph is odd whose error is so many times the median of all ...
const ODD: f64 = 4.0;
/// ... and so many times as far above it as usual on a logarithmic scale.
const FAR: f64 = 6.0;
/// Cameras are wrong where photographs are shifted by so many pixels, root mean square.
const SHIFT: f64 = 0.25;
/// Exposures change where brightness deviates by this share, root mean square.
const GAIN: f64 = 0.02;
/// Share of what photographs show that may lie outside the scene.
const OUTSIDE: f64 = 0.01;

/// What photographs and model disagree on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disagreement {
    /// Numbers of the training views whose errors are like no other's, worst first, with the
    /// PSNR of each, dB.
    pub odd: Vec<(usize, f64)>,
    /// The median PSNR of all training views, dB.
    pub usual: f64,
    /// By how many pixels photographs are shifted against the model, root mean square.
    pub shift: f64,
    /// By which share photographs are brighter or darker than the model, the channel that
    /// deviates most, root mean square.
    pub gain: f64,
    /// Share of what photographs show that lies outside the scene's box and its silhouettes.
    pub outside: f64,
}

impl Disagreement {
    /// What the user should know, a line each; `name` gives the name of a training view.
    #[must_use]
    pub fn lines(&self, name: impl Fn(usize) -> String) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some((view, psnr)) = self.odd.first() {
            let others = match self.odd.len() - 1 {
                0 => String::new(),
                n => format!(" ({n} more are as odd)"),
            };
            lines.push(format!(
                "{}: {psnr:.1} dB, expected about {:.1} as in other photographs{others}: its pose, \
                 orientation, alpha or exposure may be wrong, or something stands in front; leave \
                 it out",
                name(*view),
                self.usual
            ));
        }
        if self.shift > SHIFT {
            lines.push(format!(
                "photographs are shifted against the model by {:.2} pixels on average, expected at \
                 most {SHIFT}: poses or focal length are inexact; find them again",
                self.shift
            ));
        }
        if self.gain > GAIN {
            lines.push(format!(
                "photographs are brighter or darker than the model by {:.1} % on average, expected \
                 at most {:.0} %: exposure or white balance changes; lock them",
                100.0 * self.gain,
                100.0 * GAIN
            ));
        }
        if self.outside > OUTSIDE {
            lines.push(format!(
                "{:.1} % of what photographs show lies outside the scene's box or the silhouettes of \
                 the others, expected at most {:.0} %: the box is too small (--aabb), or poses or \
                 alpha of some photographs are wrong",
                100.0 * self.outside,
                100.0 * OUTSIDE
            ));
        }
        lines
    }
}

impl Finished<'_> {
    /// What photographs and model disagree on; `None` for a field that is still taking shape,
    /// and for one that is costly to look at.
    ///
    /// # Errors
    /// Whatever rendering reports.
    pub fn disagreement(&self) -> Result<Option<Disagreement>, Error> {
        let Trainer { config, source, backend, step, .. } = self.trainer;
        if *step < config.settled() || config.field.kind().is_costly() {
            return Ok(None);
        }
        let model = self.model();
        let settings = Settings { simd: backend.simd(), quality: 1.0, ..Settings::default() };
        let mut renderer = Renderer::new(&model, &settings);
        let mut looks = Vec::new();
        let n = source.cameras().len();
        for view in (0..n.min(VIEWS)).map(|i| i * n / n.min(VIEWS)) {
            let (camera, corner) = middle(&source.cameras()[view]);
            let picture = renderer.render_through(&camera, &source.lenses()[view])?;
            let background = model.display.srgb_background();
            let photo = crop(source, view, &camera, corner, background);
            looks.extend(compare(&picture.over(background), &photo, camera.width as usize));
        }
        let rms = |of: fn(&Look) -> f64| {
            (looks.iter().map(|look| of(look).powi(2)).sum::<f64>() / looks.len().max(1) as f64)
                .sqrt()
        };
        let errors = self.trainer.errors_of_views();
        let (odd, usual) = odd(&errors);
        let outside = self.trainer.targets.unseen_share;
        Ok(Some(Disagreement {
            odd,
            usual,
            shift: rms(|look| look.shift),
            gain: rms(|look| look.gain),
            outside,
        }))
    }
}

impl Trainer {
    /// The mean squared error of what was drawn of each training view.
    fn errors_of_views(&self) -> Vec<f64> {
        let mut sums = vec![[0.0, 0.0]; self.source.cameras().len()];
        let [errors, _] = self.sampler.state();
        for (tile, error) in errors.iter().enumerate() {
            let [sum, n] = &mut sums[self.visibility.view(tile)];
            *sum += f64::from(*error);
            *n += 1.0;
        }
        sums.into_par_iter().map(|[sum, n]| if n > 0.0 { sum / n } else { f64::NAN }).collect()
    }
}

/// Views whose errors are like no other's, with their PSNR, and the median PSNR.
fn odd(errors: &[f64]) -> (Vec<(usize, f64)>, f64) {
    let known = errors.iter().filter(|error| **error > 0.0);
    let mut logs: Vec<f64> = known.map(|error| error.ln()).collect();
    logs.sort_by(f64::total_cmp);
    let median = quantile(&logs, 0.5).unwrap_or(0.0);
    let mut off: Vec<f64> = logs.iter().map(|log| (log - median).abs()).collect();
    off.sort_by(f64::total_cmp);
    let usual = quantile(&off, 0.5).unwrap_or(0.0);
    let psnr = |log: f64| -10.0 * log / std::f64::consts::LN_10;
    let is_odd = |log: f64| log - median > ODD.ln().max(FAR * usual);
    let all = errors.iter().enumerate().filter(|(_, error)| **error > 0.0);
    let mut odd: Vec<(usize, f64)> = all
        .filter(|(_, error)| is_odd(error.ln()))
        .map(|(view, error)| (view, psnr(error.ln())))
        .collect();
    odd.sort_by(|a, b| a.1.total_cmp(&b.1));
    (odd, psnr(median))
}

/// The camera of a view's middle, and the pixel where that begins.
fn middle(camera: &Camera) -> (Camera, [u32; 2]) {
    let [width, height] = [camera.width, camera.height].map(|side| side.min(SIDE));
    let corner = [(camera.width - width) / 2, (camera.height - height) / 2];
    let center = [0, 1].map(|axis| camera.center[axis] - corner[axis] as f32);
    (Camera { width, height, center, ..*camera }, corner)
}

/// What a photograph shows there, over a background; NaN where a pixel does not count.
fn crop(
    source: &RaySource,
    view: usize,
    camera: &Camera,
    corner: [u32; 2],
    background: [f32; 3],
) -> Vec<f32> {
    let width = source.cameras()[view].width;
    let pixels = (0..camera.height).flat_map(|y| (0..camera.width).map(move |x| (x, y)));
    let mut photo = Vec::with_capacity((3 * camera.width * camera.height) as usize);
    for (x, y) in pixels {
        let (x, y) = (x + corner[0], y + corner[1]);
        let counts = source.counts(view, (y * width + x) as usize);
        let rgb = composite_on(&source.rgba(Pixel { view: view as u32, x, y }), background);
        photo.extend(rgb.into_iter().map(|value| if counts { value } else { f32::NAN }));
    }
    photo
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_odd_view_is_like_no_other() {
        let mut errors: Vec<f64> = (0..20).map(|i| 1e-3 * (1.0 + 0.05 * f64::from(i))).collect();
        assert_eq!(odd(&errors).0, []);
        errors[7] = 1e-2;
        errors[3] = f64::NAN;
        let (found, usual) = odd(&errors);
        let [(view, psnr)] = found[..] else { panic!("{found:?}") };
        assert!(view == 7 && (psnr - 20.0).abs() < 1e-9, "{view} {psnr}");
        assert!((28.0..29.0).contains(&usual), "{usual}");
        // Where errors differ anyway, more is needed.
        let wide: Vec<f64> = (0..20).map(|i| 1e-4 * 1.6f64.powi(i)).collect();
        assert_eq!(odd(&wide).0, []);
    }

    #[test]
    fn each_finding_is_a_line() {
        let none = Disagreement { usual: 30.0, ..Disagreement::default() };
        assert!(none.lines(|_| String::new()).is_empty());
        let all = Disagreement {
            odd: vec![(3, 12.0), (4, 14.0)],
            shift: 1.0,
            gain: 0.1,
            outside: 0.2,
            ..none
        };
        let lines = all.lines(|view| format!("train/{view}.png"));
        assert_eq!(lines.len(), 4);
        assert!(lines[0].starts_with("train/3.png: 12.0 dB, expected about 30.0"), "{}", lines[0]);
        assert!(lines[1].contains("1.00 pixels") && lines[2].contains("10.0 %"), "{lines:?}");
        assert!(lines[3].starts_with("20.0 % of"), "{}", lines[3]);
    }
}
