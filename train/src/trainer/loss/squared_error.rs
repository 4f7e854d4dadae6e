//! Half the squared error of the colour, expected over what may be behind the scene.

use super::{RayLoss, Rendered};
use crate::trainer::TrainingRay;

/// Its value, and its gradient times the weight of the ray.
#[inline(always)]
pub(super) fn squared_error(ray: &TrainingRay, rendered: &Rendered) -> RayLoss {
    let Some(gains) = ray.gains else {
        let off = [0, 1, 2].map(|c| rendered.color[c] - ray.target[c]);
        return of(ray, rendered, off);
    };
    // The scene is brighter in the photograph, what is behind it is not.
    let behind = ray.background.map(|value| (1.0 - rendered.opacity) * value);
    let scene = [0, 1, 2].map(|c| gains[c] * (rendered.color[c] - behind[c]));
    let off = [0, 1, 2].map(|c| scene[c] + behind[c] - ray.target[c]);
    let mut loss = of(ray, rendered, off);
    let d = loss.d_color;
    loss.d_log_gain = [0, 1, 2].map(|c| d[c] * scene[c]);
    loss.d_color = [0, 1, 2].map(|c| gains[c] * d[c]);
    // More opacity with the same colour over the background is more scene, which is brighter.
    loss.d_opacity += (0..3).map(|c| (gains[c] - 1.0) * d[c] * ray.background[c]).sum::<f32>();
    loss
}

/// Of colours that are off by so much. Where a photograph was too bright, a scene that is brighter
/// still is right.
#[inline(always)]
fn of(ray: &TrainingRay, rendered: &Rendered, off: [f32; 3]) -> RayLoss {
    let off = [0, 1, 2].map(|c| if ray.at_least[c] { off[c].min(0.0) } else { off[c] });
    let [r, g, b] = off;
    // A background that is b brighter makes `b (alpha - opacity)` of difference.
    let through = 3.0 * ray.background_variance * (rendered.opacity - ray.alpha);
    RayLoss {
        squared_error: r * r + g * g + b * b + through * (rendered.opacity - ray.alpha),
        d_color: off.map(|d| ray.weight * d),
        d_opacity: ray.weight * through,
        d_depth: 0.0,
        d_log_gain: [0.0; 3],
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::Camera;

    use super::*;
    use crate::dataset::View;
    use crate::random::Random;
    use crate::trainer::pixels::rays::{Backdrop, Pixel, RaySource};

    /// What a pixel that is drawn as `premultiplied` and `opacity` differs from an image
    /// of `rgba`, over `background`: half the sum of squares.
    fn half_squared(
        [premultiplied, rgb]: [[f32; 3]; 2],
        [opacity, alpha]: [f32; 2],
        background: f32,
    ) -> f32 {
        let off = |c: usize| {
            let drawn = premultiplied[c] + (1.0 - opacity) * background;
            drawn - (rgb[c] * alpha + (1.0 - alpha) * background)
        };
        (0..3).map(|c| 0.5 * off(c) * off(c)).sum()
    }

    #[test]
    fn the_scene_is_brighter_and_what_is_behind_it_is_not() {
        let pose = Camera::look_at([2.0; 3], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(1, 1, 0.7, pose);
        let view = View::new("", camera, vec![51, 102, 255, 153]);
        let mut source = RaySource::new(vec![view], Backdrop::Random);
        let pixel = Pixel { view: 0, x: 0, y: 0 };
        let log_gains = [0.3f32, -0.2, 0.1];
        source.brighten(vec![log_gains.map(f32::exp)]);
        let rgba = source.rgba(pixel);
        let ray = source.ray(pixel, rgba, (0, 2.0), &mut Random::new(1, [0; 3]));
        let expected = |premultiplied: [f32; 3], log_gains: [f32; 3], opacity| {
            let seen = [0, 1, 2].map(|c| premultiplied[c] * log_gains[c].exp());
            let at = |b| half_squared([seen, [0.2, 0.4, 1.0]], [opacity, 0.6], b);
            (at(0.0) + 4.0 * at(0.5) + at(1.0)) / 6.0
        };
        let (scene, opacity) = ([0.5, 0.1, 0.3], 0.9);
        let color = scene.map(|p| p + (1.0 - opacity) * 0.5);
        let error = squared_error(&ray, &Rendered { color, opacity, depth: 0.0 });
        let found = 0.5 * error.squared_error;
        assert!((found - expected(scene, log_gains, opacity)).abs() < 1e-6);
        // The weight included.
        let slope = |moved: &dyn Fn(f32) -> f32| 128.0 * (moved(0.0078125) - moved(-0.0078125));
        for c in 0..3 {
            let along = |mut from: [f32; 3], by: f32| {
                from[c] += by;
                from
            };
            let by_color = slope(&|by| expected(along(scene, by), log_gains, opacity));
            assert!((error.d_color[c] - by_color).abs() < 1e-4);
            let by_gain = slope(&|by| expected(scene, along(log_gains, by), opacity));
            assert!((error.d_log_gain[c] - by_gain).abs() < 1e-3, "{c}: {by_gain}");
        }
        // More opacity, and as much less of the mean background.
        let by_opacity =
            slope(&|by| expected(scene.map(|p| p + 0.5 * by), log_gains, opacity + by));
        assert!((error.d_opacity - by_opacity).abs() < 1e-4, "{} {by_opacity}", error.d_opacity);
    }

    #[test]
    fn light_that_passes_the_scene_of_an_opaque_photograph_is_an_error() {
        let pose = Camera::look_at([2.0; 3], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(1, 1, 0.7, pose);
        let view = View::new("", camera, vec![0, 0, 0, 255]);
        let source = RaySource::new(vec![view], Backdrop::Hidden([0.0; 3]));
        let pixel = Pixel { view: 0, x: 0, y: 0 };
        let ray = source.ray(pixel, source.rgba(pixel), (0, 2.0), &mut Random::new(1, [0; 3]));
        let error =
            |opacity| squared_error(&ray, &Rendered { color: [0.0; 3], opacity, depth: 0.0 });
        // Over random colours: a third of 0.4^2 for each channel, less the square of its mean.
        let passes = error(0.6);
        assert!((passes.squared_error - 3.0 * (0.4 * 0.4) / 12.0).abs() < 1e-6);
        let slope = (error(0.61).squared_error - error(0.59).squared_error) / 0.02;
        // Of half the error, times the ray's weight.
        assert!((passes.d_opacity - 2.0 * slope / 2.0).abs() < 1e-4);
        assert!(passes.d_opacity < 0.0 && error(1.0).squared_error == 0.0);
    }

    #[test]
    fn a_scene_too_bright_for_its_photograph_is_no_error() {
        let pose = Camera::look_at([2.0; 3], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(1, 1, 0.7, pose);
        let view = View::new("", camera, vec![255, 255, 102, 255]);
        let mut source = RaySource::new(vec![view], Backdrop::Color([0.0; 3]));
        // Red and blue are darkened, to 153 and 61; red was as bright as can be, green still is.
        source.even_out(vec![[0.6, 1.0, 0.6]]);
        let pixel = Pixel { view: 0, x: 0, y: 0 };
        let ray = source.ray(pixel, source.rgba(pixel), (0, 2.0), &mut Random::new(1, [0; 3]));
        assert_eq!(ray.at_least, [true, false, false]);
        let error = |color| squared_error(&ray, &Rendered { color, opacity: 1.0, depth: 0.0 });
        let blue = 61.0 / 255.0;
        let brighter = error([0.9, 0.9, blue + 0.1]);
        assert!((brighter.squared_error - 0.02).abs() < 1e-4, "{}", brighter.squared_error);
        for (d, expected) in brighter.d_color.into_iter().zip([0.0, -0.2, 0.2]) {
            assert!((d - expected).abs() < 1e-3, "{:?}", brighter.d_color);
        }
        let darker = error([0.5, 1.0, blue]);
        assert!((darker.squared_error - 0.01).abs() < 1e-4, "{}", darker.squared_error);
        assert!((darker.d_color[0] + 0.2).abs() < 1e-3, "{:?}", darker.d_color);
        // So with gains that are learnt: a scene twice as bright in the photograph is too bright
        // for it, and tells nothing of how bright it was.
        source.brighten(vec![[2.0; 3]]);
        let ray = source.ray(pixel, source.rgba(pixel), (0, 2.0), &mut Random::new(1, [0; 3]));
        let color = [0.4, 0.5, 0.12];
        let error = squared_error(&ray, &Rendered { color, opacity: 1.0, depth: 0.0 });
        assert!(error.squared_error < 1e-4 && error.d_log_gain[0] == 0.0);
    }

    #[test]
    fn the_error_is_the_mean_over_all_backgrounds() {
        let pose = Camera::look_at([2.0; 3], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(1, 1, 0.7, pose);
        let view = || View::new("", camera, vec![51, 102, 255, 153]);
        let source = RaySource::new(vec![view()], Backdrop::Random);
        let pixel = Pixel { view: 0, x: 0, y: 0 };
        let rgba = source.rgba(pixel);
        let ray = source.ray(pixel, rgba, (7, 2.0), &mut Random::new(1, [0; 3]));
        assert_eq!((ray.tile, ray.weight), (7, 2.0));
        let (rgb, alpha) = ([0.2, 0.4, 1.0], 0.6);
        // Simpson's rule is exact for squares.
        let expected = |premultiplied, opacity| {
            let at = |b| half_squared([premultiplied, rgb], [opacity, alpha], b);
            (at(0.0) + 4.0 * at(0.5) + at(1.0)) / 6.0
        };
        let (premultiplied, opacity) = ([0.5, 0.1, 0.3], 0.9);
        let color = premultiplied.map(|p| p + (1.0 - opacity) * 0.5);
        let error = squared_error(&ray, &Rendered { color, opacity, depth: 0.0 });
        assert!((0.5 * error.squared_error - expected(premultiplied, opacity)).abs() < 1e-6);
        // The gradients against differences, the weight included.
        for c in 0..3 {
            let moved = |by: f32| {
                let mut other = premultiplied;
                other[c] += by;
                expected(other, opacity)
            };
            let slope = (moved(0.125) - moved(-0.125)) / 0.25;
            assert!((error.d_color[c] - 2.0 * slope).abs() < 1e-5);
        }
        // More opacity, and as much less of the mean background.
        let moved = |by: f32| expected(premultiplied.map(|p| p + 0.5 * by), opacity + by);
        let slope = (moved(0.125) - moved(-0.125)) / 0.25;
        assert!((error.d_opacity - 2.0 * slope).abs() < 1e-5);
        // One colour behind: nothing is spread.
        let source = RaySource::new(vec![view()], Backdrop::Color([1.0; 3]));
        let ray = source.ray(pixel, rgba, (0, 1.0), &mut Random::new(1, [0; 3]));
        let color = premultiplied.map(|p| p + (1.0 - opacity));
        let error = squared_error(&ray, &Rendered { color, opacity, depth: 0.0 });
        let expected = half_squared([premultiplied, rgb], [opacity, alpha], 1.0);
        assert!((0.5 * error.squared_error - expected).abs() < 1e-6);
        assert_eq!(error.d_opacity, 0.0);
    }
}
