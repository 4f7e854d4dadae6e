//! Photographs that do not agree with the model, or with each other.
//!
//! A field that was shown contradictions learns their mean, and training's PSNR does not say why
//! it is low. What is wrong can be told from the pictures: cameras that are not where they should
//! be see the model shifted, a blurred photograph has weaker edges than it, and one of something
//! else has an error like no other.

mod compare;
mod cut;

use pocketnerf_core::{Camera, Error};

use super::Finished;
use crate::metrics::{composite_on, mean, median};
use crate::picture::{Renderer, Settings};
use crate::trainer::Trainer;
use crate::trainer::held_out::HeldOut;
use crate::trainer::pixels::importance::UNKNOWN;
use crate::trainer::pixels::rays::{Pixel, RaySource};
use crate::trainer::run::LONG_ENOUGH;
use compare::{Look, compare};

/// Views that are looked at, at most, evenly spread.
const VIEWS: usize = 32;
/// Of smaller pictures a part of a pixel is much.
const LEAST: u32 = 64;
/// Pixels along a side of the part of each quarter of a view that is looked at.
const SIDE: u32 = 32;
/// A photograph is odd whose error is so many times the median of all ...
const ODD: f64 = 4.0;
/// ... and so many times as far above it as usual on a logarithmic scale.
const FAR: f64 = 6.0;
/// What is learnt as well as this, dB, is not wrong, however well the others are learnt.
const WELL: f64 = 34.0;
/// A photograph that was held out for most of a long run is odd if it is so many dB worse than
/// usual: it had less time to be learnt.
const HELD_ODD: f64 = 15.0;
/// Cameras are wrong where photographs are shifted by this share of their width, root mean square.
const SHIFT: f64 = 3e-3;
/// Share of what photographs show that may lie outside the scene.
const OUTSIDE: f64 = 0.01;
/// Share of the occupied cells that `near` and `far` may hide from a camera.
const CUT: f64 = 0.01;
/// A photograph is blurred whose edges are so many times as strong as the median, both as they are
/// and beside the model's ...
const BLURRED: f64 = 0.5;
/// ... and whose PSNR is so many dB lower than usual: fog has weak edges and is right.
const WORSE: f64 = 1.0;
/// Rows between two in which a photograph's edges are looked at.
const ROWS_APART: usize = 4;

/// What photographs and model disagree on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disagreement {
    /// Numbers of the training views whose errors are like no other's, worst first, with the
    /// PSNR of each, dB.
    pub odd: Vec<(usize, f64)>,
    /// The median PSNR of all training views, dB.
    pub usual: f64,
    /// By which share of their width photographs are shifted against the model, root mean square.
    pub shift: f64,
    /// Share of what photographs show that lies outside the scene's box and its silhouettes.
    pub outside: f64,
    /// Share of the occupied cells that lie nearer than `near` or farther than `far`, the mean over
    /// the cameras.
    pub cut: f64,
    /// Numbers of the training views that are blurred.
    pub blurred: Vec<usize>,
}

impl Disagreement {
    /// What the user should know, a line each; `name` gives the name of a training view.
    #[must_use]
    pub fn lines(&self, name: impl Fn(usize) -> String) -> Vec<String> {
        let others = |n: usize| match n - 1 {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        let mut lines = Vec::new();
        if self.cut > CUT {
            lines.push(format!(
                "near and far hide {:.0} % of the scene from the cameras, expected at most {:.0} %; \
                 leave out --near and --far, or widen them",
                100.0 * self.cut,
                100.0 * CUT
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
        if let Some((view, psnr)) = self.odd.first() {
            lines.push(format!(
                "{}{}: {psnr:.1} dB, expected about {:.1} as in other photographs: pose, \
                 orientation, alpha or exposure may be wrong, or something stands in front; leave \
                 them out",
                name(*view),
                others(self.odd.len()),
                self.usual
            ));
        }
        // These follow from what was said.
        if !lines.is_empty() {
            return lines;
        }
        if self.shift > SHIFT {
            lines.push(format!(
                "photographs are shifted against the model by {:.2} % of their width on average, \
                 expected at most {} %: poses or focal length are inexact; find them again",
                100.0 * self.shift,
                100.0 * SHIFT
            ));
        }
        if let Some(view) = self.blurred.first() {
            lines.push(format!(
                "{}{}: blurred beside the other photographs; leave them out",
                name(*view),
                others(self.blurred.len())
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
        let (mut looks, mut sharpness) = (Vec::new(), Vec::new());
        let n = source.cameras().len();
        let held = self.trainer.held_out_for_long();
        let views = (0..n.min(VIEWS)).map(|i| i * n / n.min(VIEWS));
        let large = |view: &usize| source.cameras()[*view].width >= LEAST;
        for view in views.filter(|view| !held.has(*view)).filter(large) {
            // As it looks, or light alone: over black, what is transparent says nothing.
            let behind = source.behind(view).unwrap_or([0.0; 3]);
            let mut own = Vec::new();
            for (camera, corner) in quarters(&source.cameras()[view]) {
                let picture = renderer.render_through(&camera, &source.lenses()[view])?;
                let photo = crop(source, view, &camera, corner, behind);
                let all = f64::from(source.cameras()[view].width);
                let look = compare(&picture.over(behind), &photo, camera.width as usize);
                own.extend(look.map(|look| Look { shift: look.shift / all, ..look }));
            }
            let edges = own.iter().map(|look| look.edges);
            let [photo, model] = edges.fold([0.0; 2], |sum, [a, b]| [sum[0] + a, sum[1] + b]);
            if model > 0.0 {
                sharpness.push((view, [photo / model, edges_of(source, view)]));
            }
            looks.extend(own);
        }
        let errors = self.trainer.errors_of_views(&held);
        let (mut odd, usual) = odd(&errors);
        if *step >= LONG_ENOUGH {
            odd.extend(self.trainer.odd_among(&held, usual));
        }
        let usual_sharpness =
            [0, 1].map(|i| median(sharpness.iter().map(|(_, own)| own[i])).unwrap_or(0.0));
        let is_blurred = |own: [f64; 2]| (0..2).all(|i| own[i] < BLURRED * usual_sharpness[i]);
        Ok(Some(Disagreement {
            odd,
            usual,
            shift: rms(looks.iter().map(|look| look.shift)),
            outside: self.trainer.targets.unseen_share,
            cut: cut::share(&model, source.cameras()),
            blurred: sharpness
                .iter()
                .filter(|(view, s)| is_blurred(*s) && psnr(errors[*view]) < usual - WORSE)
                .map(|(view, _)| *view)
                .collect(),
        }))
    }
}

/// The mean squared step from pixel to pixel of a photograph's green, where it is opaque.
fn edges_of(source: &RaySource, view: usize) -> f64 {
    let width = source.cameras()[view].width as usize;
    let rows = source.images()[view].chunks(4 * width).step_by(ROWS_APART);
    let pairs = rows.flat_map(|row| row.as_chunks::<4>().0.windows(2));
    let opaque = pairs.filter(|pair| pair[0][3] == u8::MAX && pair[1][3] == u8::MAX);
    mean(opaque.map(|pair| f64::from(pair[0][1].abs_diff(pair[1][1])).powi(2))).unwrap_or(0.0)
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|value| value * value)).unwrap_or(0.0).sqrt()
}

impl Trainer {
    /// Views that were held out for most of the run: all long ones have some, even where the
    /// part that was resumed does not know, and short ones whose end the clock decides.
    pub(in crate::trainer) fn held_out_for_long(&self) -> HeldOut {
        match self.step < LONG_ENOUGH {
            true => self.returned.clone(),
            false => HeldOut::choose(&self.source, self.config.seed),
        }
    }

    /// Those of the views that were held out that are far worse than usual, with their PSNR.
    fn odd_among(&self, held: &HeldOut, usual: f64) -> Vec<(usize, f64)> {
        let errors = self.errors_of_views(&HeldOut::default()).into_iter().enumerate();
        let held = errors.filter(|(view, error)| held.has(*view) && *error > 0.0);
        let values = held.map(|(view, error)| (view, psnr(error)));
        values.filter(|(_, found)| *found < (usual - HELD_ODD).min(WELL)).collect()
    }

    /// The mean squared error of what was drawn of each training view; NaN where little was, as of
    /// those that were held out.
    fn errors_of_views(&self, held: &HeldOut) -> Vec<f64> {
        let mut sums = vec![[0.0, 0.0]; self.source.cameras().len()];
        let [errors, _] = self.sampler.state();
        for (tile, error) in errors.iter().enumerate().filter(|(_, error)| **error != UNKNOWN) {
            let [sum, n] = &mut sums[self.visibility.view(tile)];
            *sum += f64::from(*error);
            *n += 1.0;
        }
        let mean = |(view, [sum, n]): (usize, [f64; 2])| {
            if n > 0.0 && !held.has(view) { sum / n } else { f64::NAN }
        };
        sums.into_iter().enumerate().map(mean).collect()
    }
}

/// Of a mean squared error, dB.
fn psnr(error: f64) -> f64 {
    -10.0 * error.log10()
}

/// Views whose errors are like no other's, with their PSNR, and the median PSNR.
fn odd(errors: &[f64]) -> (Vec<(usize, f64)>, f64) {
    let logs = || errors.iter().filter(|error| **error > 0.0).map(|error| error.ln());
    let middle = median(logs()).unwrap_or(0.0);
    let usual = median(logs().map(|log| (log - middle).abs())).unwrap_or(0.0);
    let is_odd = |log: f64| log - middle > ODD.ln().max(FAR * usual) && psnr(log.exp()) < WELL;
    let all = errors.iter().enumerate().filter(|(_, error)| **error > 0.0);
    let mut odd: Vec<(usize, f64)> = all
        .filter(|(_, error)| is_odd(error.ln()))
        .map(|(view, error)| (view, psnr(*error)))
        .collect();
    odd.sort_by(|a, b| a.1.total_cmp(&b.1));
    (odd, psnr(middle.exp()))
}

/// The cameras of the middles of a view's quarters, and the pixel where each begins.
fn quarters(camera: &Camera) -> impl Iterator<Item = (Camera, [u32; 2])> {
    let camera = *camera;
    let half = [camera.width, camera.height].map(|side| (side / 2).max(1));
    let size = half.map(|side| side.min(SIDE));
    (0..4).map(move |i| {
        let corner = [0, 1].map(|a| half[a] * (i >> a & 1) + (half[a] - size[a]) / 2);
        let center = [0, 1].map(|a| camera.center[a] - corner[a] as f32);
        (Camera { width: size[0], height: size[1], center, ..camera }, corner)
    })
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
        // 36 dB where the others have 47 is still 36.
        let mut small: Vec<f64> = (0..20).map(|i| 2e-5 * (1.0 + 0.05 * f64::from(i))).collect();
        small[7] = 2.5e-4;
        assert_eq!(odd(&small).0, []);
        small[7] = 2.5e-3;
        assert_eq!(odd(&small).0[..], [(7, super::psnr(2.5e-3))]);
        // Where errors differ anyway, more is needed.
        let wide: Vec<f64> = (0..20).map(|i| 1e-4 * 1.6f64.powi(i)).collect();
        assert_eq!(odd(&wide).0, []);
    }

    #[test]
    fn each_finding_is_a_line() {
        let none = Disagreement { usual: 30.0, ..Disagreement::default() };
        let lines = |all: Disagreement| all.lines(|view| format!("train/{view}.png"));
        assert!(lines(none.clone()).is_empty());
        let odd = vec![(3, 12.0), (4, 14.0)];
        let found =
            lines(Disagreement { odd, cut: 0.3, outside: 0.2, shift: 0.01, ..none.clone() });
        // What follows from these is not said.
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].contains("hide 30 %") && found[1].starts_with("20.0 % of"), "{found:?}");
        assert!(found[2].starts_with("train/3.png and 1 more: 12.0 dB, expected about 30.0"));
        let blurred = vec![2];
        let found = lines(Disagreement { blurred, shift: 0.01, ..none });
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("1.00 % of their width"), "{found:?}");
        assert!(found[1].starts_with("train/2.png: blurred"), "{found:?}");
    }

    #[test]
    fn quarters_are_parts_of_the_picture() {
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let whole = Camera::from_fov_x(200, 100, 0.7, pose);
        let parts: Vec<_> = quarters(&whole).collect();
        assert_eq!(parts.len(), 4);
        for (part, [x, y]) in parts {
            assert_eq!([part.width, part.height], [SIDE; 2]);
            let (here, there) = (part.ray(3.5, 7.5), whole.ray(x as f32 + 3.5, y as f32 + 7.5));
            let off = glam::Vec3::from(here.direction) - glam::Vec3::from(there.direction);
            assert!(off.length() < 1e-6 && x + SIDE <= 200 && y + SIDE <= 100);
        }
    }
}
