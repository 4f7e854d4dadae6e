//! One step of an image's planes: rendered from a photograph's camera, compared, and corrected.

use pocketnerf_core::Ray;
use rayon::prelude::*;

use super::planes::{Local, Planes};
use crate::network::Real;

/// Light below which planes behind are not seen.
const DARK: f64 = 1e-4;

/// A pixel and the colour that it is to have.
pub(super) struct Target {
    pub(super) ray: Ray,
    pub(super) color: [f32; 3],
    pub(super) counts: bool,
}

/// What pixels hand back to the planes.
pub(super) struct Seen<'p, T> {
    planes: &'p Planes,
    pixels: Vec<Pixel<T>>,
}

/// What one does.
struct Pixel<T> {
    local: Option<Local>,
    /// How far its colour is off.
    off: [T; 3],
    /// Of each plane: its share of the colour, and the gradient of its opacity.
    planes: Vec<[T; 2]>,
}

impl<'p, T: Real> Seen<'p, T> {
    /// Renders pixels. `values` are colours and opacities of all planes, near ones first: sRGB and
    /// opacity, 0 to 1, row after row.
    pub(super) fn of(
        planes: &'p Planes,
        values: &[&[[T; 4]]],
        targets: &[Target],
        background: [f32; 3],
    ) -> Self {
        let see = |target| see(planes, values, target, background);
        Self { planes, pixels: targets.par_iter().map(see).collect() }
    }

    /// The mean squared error of the pixels that meet the last plane.
    pub(super) fn error(&self) -> f64 {
        let met = self.pixels.iter().filter(|pixel| pixel.local.is_some());
        let n = met.clone().count().max(1);
        self.squares(met) / (3 * n) as f64
    }

    fn squares<'s>(&'s self, pixels: impl Iterator<Item = &'s Pixel<T>>) -> f64 {
        pixels.flat_map(|pixel| pixel.off).map(|off| off.value() * off.value()).sum()
    }

    /// The gradient of the sum of squared errors with respect to a plane's values.
    pub(super) fn gradient(&self, plane: usize) -> Vec<[T; 4]> {
        let width = self.planes.size()[0];
        let mut gradient = vec![[T::zero(); 4]; self.planes.pixels()];
        for pixel in &self.pixels {
            let Some(local) = &pixel.local else { continue };
            let [share, opacity] = pixel.planes[plane];
            if share == T::zero() && opacity == T::zero() {
                continue;
            }
            let Some(spot) = self.planes.spot(local, plane) else { continue };
            let two = T::of(2.0);
            let [r, g, b] = pixel.off.map(|off| two * off * share);
            let d = [r, g, b, two * opacity];
            for (pixel, part) in spot.pixels(width) {
                let part = T::of(f64::from(part));
                gradient[pixel].iter_mut().zip(d).for_each(|(sum, d)| *sum += d * part);
            }
        }
        gradient
    }
}

/// Renders a pixel, and finds how it depends on each plane. One that does not meet the last plane
/// depends on nothing.
fn see<T: Real>(
    planes: &Planes,
    values: &[&[[T; 4]]],
    target: &Target,
    background: [f32; 3],
) -> Pixel<T> {
    let nothing = || Pixel { local: None, off: [T::zero(); 3], planes: Vec::new() };
    let local = target.counts.then(|| planes.local(&target.ray)).flatten();
    let Some(local) = local else { return nothing() };
    let n = values.len();
    if planes.spot(&local, n - 1).is_none() {
        return nothing();
    }
    let mut met = vec![[T::zero(); 5]; n];
    let mut color = [T::zero(); 3];
    let mut light = T::one();
    let mut last = n;
    for (k, met) in met.iter_mut().enumerate() {
        if light < T::of(DARK) {
            last = k;
            break;
        }
        let rgba = planes.spot(&local, k).map_or([T::zero(); 4], |spot| {
            let mut sum = [T::zero(); 4];
            for (pixel, part) in spot.pixels(planes.size()[0]) {
                let part = T::of(f64::from(part));
                sum.iter_mut().zip(values[k][pixel]).for_each(|(sum, v)| *sum += v * part);
            }
            sum
        });
        let [r, g, b, opacity] = rgba;
        *met = [r, g, b, opacity, light];
        color.iter_mut().zip(rgba).for_each(|(sum, c)| *sum += light * opacity * c);
        light *= T::one() - opacity;
    }
    let behind = background.map(|c| T::of(f64::from(c)));
    let off = [0, 1, 2].map(|c| color[c] + light * behind[c] - T::of(f64::from(target.color[c])));
    // From the last plane to the first: what is seen behind each.
    let mut behind = behind;
    let mut shares = vec![[T::zero(); 2]; n];
    for (share, [r, g, b, opacity, light]) in shares[..last].iter_mut().zip(&met[..last]).rev() {
        let own = [*r, *g, *b];
        let d: T = (0..3).map(|c| off[c] * (own[c] - behind[c])).sum();
        *share = [*light * *opacity, *light * d];
        for c in 0..3 {
            behind[c] = *opacity * own[c] + (T::one() - *opacity) * behind[c];
        }
    }
    Pixel { local: Some(local), off, planes: shares }
}
