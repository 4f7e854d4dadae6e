//! Photographs that are blurred, or full of noise, beside others of the same scene.

use super::compare::{LAPLACIAN, Products};
use crate::metrics::{mean, median, quantile};
use crate::trainer::pixels::rays::RaySource;

/// A photograph is blurred whose difference to the model's picture is by so much more of the
/// picture's Laplacian than usual: a box of 3x3 pixels gives a third, of which the field learns up
/// to a half; sharp ones of ferns reach 0.12 ...
const BLURRED: f64 = 0.15;
/// ... and so many times as far from the median as half of them are: a sixth of all may be blurred.
const FAR: f64 = 6.0;
/// Parts of a view that say something, at least.
const FEWEST: usize = 3;
/// A photograph has noise of at least this standard deviation, of 255 ...
const NOISY: f64 = 12.0;
/// ... and so many times as much as usual: leaves and gravel look like noise in all of them.
const NOISIER: f64 = 3.0;
/// Blocks of so many pixels along a side, of which this share is flat in most photographs.
const BLOCK: usize = 8;
const FLATTEST: f64 = 0.1;

/// Which of the views are blurred.
pub(super) fn blurred(views: &[Vec<Products>]) -> Vec<bool> {
    let blur = |parts: &Vec<Products>| {
        let own = parts.iter().map(|part| part.in_place().share(LAPLACIAN));
        median(own).filter(|_| parts.len() >= FEWEST)
    };
    let own: Vec<Option<f64>> = views.iter().map(blur).collect();
    let known = || own.iter().flatten().copied();
    let usual = median(known()).unwrap_or(0.0);
    let spread = median(known().map(|blur| (blur - usual).abs())).unwrap_or(0.0);
    let limit = usual + BLURRED.max(FAR * spread);
    own.iter().map(|blur| blur.is_some_and(|blur| blur > limit)).collect()
}

/// Which of the views are noisy, of the noise of each, and the usual noise.
pub(super) fn noisy(noise: &[Option<f64>]) -> (Vec<bool>, f64) {
    let usual = median(noise.iter().flatten().copied()).unwrap_or(0.0);
    let limit = NOISY.max(NOISIER * usual);
    (noise.iter().map(|noise| noise.is_some_and(|noise| noise > limit)).collect(), usual)
}

/// The standard deviation of noise in a photograph's green, of 255: what the flattest blocks
/// have that is neither constant nor a slope (Immerkaer 1996). `None` where too little of it is
/// opaque and neither black nor as bright as can be.
pub(super) fn noise(source: &RaySource, view: usize) -> Option<f64> {
    let camera = &source.cameras()[view];
    let (width, height) = (camera.width as usize, camera.height as usize);
    let pixels = source.images()[view].as_chunks::<4>().0;
    let mut blocks = Vec::new();
    for y in (1..height.saturating_sub(BLOCK)).step_by(BLOCK) {
        for x in (1..width.saturating_sub(BLOCK)).step_by(BLOCK) {
            let all = (0..BLOCK * BLOCK).map(|i| (x + i % BLOCK, y + i / BLOCK));
            let squares = all.filter_map(|(x, y)| roughness(pixels, width, x, y));
            let squares: Vec<f64> = squares.map(|value| value * value).collect();
            if 2 * squares.len() >= BLOCK * BLOCK {
                blocks.extend(mean(squares.into_iter()));
            }
        }
    }
    blocks.sort_by(f64::total_cmp);
    quantile(&blocks, FLATTEST).map(f64::sqrt)
}

/// The difference of two Laplacians, scaled so that noise has its own standard deviation.
fn roughness(pixels: &[[u8; 4]], width: usize, x: usize, y: usize) -> Option<f64> {
    let mut sum = 0.0;
    for (i, weight) in [1.0, -2.0, 1.0, -2.0, 4.0, -2.0, 1.0, -2.0, 1.0].into_iter().enumerate() {
        let [_, green, _, alpha] = pixels[(y + i / 3 - 1) * width + x + i % 3 - 1];
        if alpha != u8::MAX || green == 0 || green == u8::MAX {
            return None;
        }
        sum += weight * f64::from(green);
    }
    Some(sum / 6.0)
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::Camera;

    use super::super::compare::tests::{compare, picture};
    use super::*;
    use crate::dataset::View;
    use crate::random::{Random, normal};
    use crate::trainer::pixels::rays::Backdrop;

    #[test]
    fn blurred_photographs_are_told_from_others() {
        let sharp = picture(|at| at, 1.0);
        // Waves of less contrast, as blur leaves them.
        let soft: Vec<f32> = sharp.iter().map(|value| 0.02 * 0.5 + 0.98 * value).collect();
        let part = |photo| compare(&sharp, photo, &[4.0; 1600]).unwrap();
        let view = |photo| vec![part(photo); 4];
        let mut views = vec![view(&sharp); 8];
        views[3] = view(&soft);
        views[5] = vec![part(&soft), part(&sharp), part(&sharp)];
        views[6].truncate(2);
        let found = blurred(&views);
        assert_eq!(found, [false, false, false, true, false, false, false, false]);
    }

    #[test]
    fn noise_is_what_flat_blocks_have() {
        let mut random = Random::new(3, [0; 3]);
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let mut view = |deviation: f32| {
            let mut rgba = Vec::new();
            for i in 0..64 * 64 {
                let slope = 60.0 + (i % 64) as f32;
                let value = (slope + deviation * normal(&mut random)).round() as u8;
                rgba.extend([value, value, value, 255]);
            }
            View::new("", Camera::from_fov_x(64, 64, 0.7, pose), rgba)
        };
        let views = vec![view(0.0), view(20.0)];
        let source = RaySource::new(views, Backdrop::Random);
        let found = [0, 1].map(|view| noise(&source, view));
        // Of 64 pixels that overlap, a tenth of the blocks have less than three quarters of it.
        assert!(found[0] == Some(0.0) && (14.0..17.0).contains(&found[1].unwrap()), "{found:?}");
        // A tenth of the blocks have less than the mean.
        let usual = [Some(2.0), None, Some(1.0), Some(15.0), Some(3.0)];
        assert_eq!(noisy(&usual), (vec![false, false, false, true, false], 2.5));
        assert_eq!(noisy(&[Some(8.0), Some(9.0), Some(20.0)]).0, [false; 3]);
    }
}
