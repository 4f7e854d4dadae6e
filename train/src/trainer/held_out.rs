//! Held-out views: a few training views that most of a run does not learn from. Training's own
//! PSNR rises whether a field learns the scene or the photographs; theirs tells.

use pocketnerf_core::{Camera, Display, Error, Model, SimdLevel};

use crate::cameras::EveryFew;
use crate::lens::Lens;
use crate::metrics::{composite_on, masked, psnr, quantize_all};
use crate::picture::{Renderer, Settings};
use crate::trainer::pixels::rays::{Pixel, RaySource};

/// One view in so many is held out ...
const ONE_IN: usize = 25;
/// ... and at least so many: fog before the camera of a single one comes and goes, by a decibel from
/// look to look.
const LEAST: usize = 3;
/// Pixels of a look, about.
const PIXELS: f64 = 16_384.0;
/// PSNR of pictures that are equal to the byte, dB.
const EQUAL: f64 = 99.0;

/// PSNR of the held-out views, dB, as `eval` measures it, from every few pixels along both
/// sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeldOutPsnr {
    /// Mean of the views.
    pub mean: f64,
    /// The worst view's.
    pub min: f64,
}

/// Some views, as a source of rays numbers them.
#[derive(Clone, Debug, Default)]
pub(crate) struct HeldOut {
    views: Vec<HeldOutView>,
}

/// Every few pixels of a view.
#[derive(Clone, Debug)]
struct HeldOutView {
    number: usize,
    camera: Camera,
    lens: Lens,
    /// Straight RGBA of the pixels.
    rgba: Vec<u8>,
    /// 0 where one does not count.
    mask: Vec<u8>,
}

impl HeldOut {
    /// Chooses one view in 25, at least three, spread evenly around what the cameras look at;
    /// other ones for another seed. Where views are few, all are needed, and none is held out.
    pub(crate) fn choose(source: &RaySource, seed: u64) -> Self {
        let order = around(source.photographs());
        let n = order.len();
        if source.has_few_views() {
            return Self::default();
        }
        let held = (n / ONE_IN).max(LEAST);
        let first = seed % n.div_ceil(held) as u64;
        let numbers = (0..held).map(|i| order[i * n / held + first as usize]);
        let numbers: Vec<usize> = numbers.collect();
        let cameras = numbers.iter().map(|number| &source.cameras()[*number]);
        let apart = EveryFew::apart(cameras, PIXELS);
        let views = numbers.into_iter().map(|number| HeldOutView::new(source, number, apart));
        Self { views: views.collect() }
    }

    /// How many.
    pub(crate) fn len(&self) -> usize {
        self.views.len()
    }

    /// Whether it has this view.
    pub(crate) fn has(&self, view: usize) -> bool {
        self.views.iter().any(|held| held.number == view)
    }

    /// How close a model comes to them; `None` without views.
    pub(crate) fn look(
        &self,
        model: &Model<'_>,
        simd: SimdLevel,
    ) -> Result<Option<HeldOutPsnr>, Error> {
        let settings = Settings { simd, quality: 1.0, ..Settings::default() };
        let mut renderer = Renderer::new(model, &settings);
        let mut values = Vec::with_capacity(self.views.len());
        for view in &self.views {
            let picture = renderer.render_through(&view.camera, &view.lens)?;
            values.push(view.psnr(&picture.rgb8(&model.display), &model.display));
        }
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let min = values.into_iter().reduce(f64::min);
        Ok(min.map(|min| HeldOutPsnr { mean, min }))
    }
}

impl HeldOutView {
    fn new(source: &RaySource, number: usize, apart: u32) -> Self {
        let whole = &source.cameras()[number];
        let few = EveryFew::new(whole, apart);
        let pixels = few.pixels().map(|[x, y]| Pixel { view: number as u32, x, y });
        let index = |pixel: &Pixel| (pixel.y * whole.width + pixel.x) as usize;
        Self {
            number,
            camera: few.camera,
            lens: source.lenses()[number],
            rgba: pixels.clone().flat_map(|pixel| source.rgba(pixel)).collect(),
            mask: pixels.map(|pixel| source.is_exact(number, index(&pixel)).into()).collect(),
        }
    }

    /// Of a picture of its pixels.
    fn psnr(&self, picture: &[u8], display: &Display) -> f64 {
        let truth = quantize_all(&composite_on(&self.rgba, display.srgb_background()));
        let ([picture, truth], _) = masked(picture, &truth, Some(&self.mask));
        // Every few pixels may all be pixels that do not count.
        if truth.is_empty() { EQUAL } else { psnr(&picture, &truth).min(EQUAL) }
    }
}

/// The cameras' numbers in the order of their positions around the mean direction in which
/// they look.
fn around(cameras: &[Camera]) -> Vec<usize> {
    let n = cameras.len().max(1) as f32;
    let sum = |of: &dyn Fn(&Camera) -> glam::Vec3| cameras.iter().map(of).sum::<glam::Vec3>() / n;
    let position = |camera: &Camera| glam::Vec3::from(camera.position());
    let middle = sum(&position);
    let axis = sum(&|camera| camera.axis().into()).try_normalize().unwrap_or(glam::Vec3::Z);
    let (u, v) = axis.any_orthonormal_pair();
    let angle = |i: &usize| {
        let from = position(&cameras[*i]) - middle;
        from.dot(v).atan2(from.dot(u))
    };
    let mut order: Vec<usize> = (0..cameras.len()).collect();
    order.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::dataset::{Split, View};
    use crate::trainer::Backdrop;

    fn source(views: usize) -> RaySource {
        let mut dataset = builtin::dataset(Split::Train, 40);
        dataset.views.truncate(views);
        RaySource::new(dataset.views, Backdrop::Random)
    }

    #[test]
    fn a_few_views_are_held_out() {
        let all = source(usize::MAX);
        let chosen = |source: &RaySource, seed| -> Vec<usize> {
            HeldOut::choose(source, seed).views.iter().map(|view| view.number).collect()
        };
        assert_eq!((chosen(&all, 3).len(), chosen(&all, 3)), (3, chosen(&all, 3)));
        let mut twice = builtin::dataset(Split::Train, 40).views;
        twice.extend(twice.clone());
        assert_eq!(
            (twice.len(), chosen(&RaySource::new(twice, Backdrop::Random), 0).len()),
            (120, 4)
        );
        // Three of not many, each view in its turn.
        assert!((0..32).all(|seed| chosen(&source(32), seed).len() == 3));
        let mut turns: Vec<usize> = (0..11).flat_map(|seed| chosen(&source(32), seed)).collect();
        turns.sort_unstable();
        turns.dedup();
        assert_eq!(turns, (0..32).collect::<Vec<_>>());
        assert!(chosen(&source(31), 0).is_empty());
    }

    #[test]
    fn psnr_by_hand() {
        let camera =
            Camera::from_fov_x(2, 1, 0.9, Camera::look_at([2.0; 3], [0.0; 3], [0.0, 0.0, 1.0]));
        let view = View {
            mask: Some(vec![255, 0]),
            ..View::new("", camera, vec![0, 0, 0, 255, 9, 9, 9, 255])
        };
        let source = RaySource::new(vec![view], Backdrop::Random);
        let view = HeldOutView::new(&source, 0, 1);
        let display = Display {
            background: [1.0; 3],
            color_space: pocketnerf_core::ColorSpace::Srgb,
            tolerance: Display::TOLERANCE,
        };
        // A fifth off in one channel of three; the other pixel does not count.
        let found = view.psnr(&[51, 0, 0, 200, 0, 0], &display);
        assert!((found + 10.0 * (0.04f64 / 3.0).log10()).abs() < 1e-9, "{found}");
        assert_eq!(view.psnr(&[0, 0, 0, 1, 1, 1], &display), EQUAL);
    }
}
