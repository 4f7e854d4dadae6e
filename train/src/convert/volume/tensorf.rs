//! Rays through a model of TensoRF, as `TensorBase.forward` renders them.

use fearless_simd::Level;
use pocketnerf_core::{Error, Ray};
use pocketnerf_formats::import::volume::{AlphaMask, TensoRf};

use super::factors::{Place, products};
use super::rays::{at, within};
use super::shade::{Sample, Shader};
use super::{LEAST_LIGHT, Volume};

/// A field, ready to be rendered.
#[derive(Debug)]
pub(super) struct Tensors {
    field: TensoRf,
    level: Level,
}

impl Tensors {
    pub(super) fn new(field: TensoRf, level: Level) -> Result<Self, Error> {
        // What core refuses of its layers, it refuses here.
        Shader::new(&field)?;
        Ok(Self { field, level })
    }

    /// The density at a point of the box, 1 / unit length.
    fn density(&self, point: [f32; 3], sums: &mut [f32]) -> f32 {
        let TensoRf { bounds, sizes, density, softplus, density_shift, .. } = &self.field;
        products(density, Place::of(point, *bounds, *sizes), *sizes, sums);
        let sum = sums.iter().sum::<f32>();
        let value = match softplus {
            // Without overflow.
            true => {
                let x = sum + density_shift;
                x.max(0.0) + (-x.abs()).exp().ln_1p()
            }
            false => sum.max(0.0),
        };
        value * self.field.distance_scale
    }

    /// Marches along a ray: what of it has a colour goes to `sample`; its opacity.
    fn march(&self, ray: &Ray, sums: &mut [f32], mut sample: impl FnMut(Sample)) -> (f32, u64) {
        let TensoRf { bounds, near_far: [near, far], step, weight_threshold, .. } = self.field;
        let [enter, leave] = within(ray.origin, ray.direction, bounds);
        let (mut light, mut count) = (1.0f32, 0);
        if leave < enter {
            return (0.0, 0);
        }
        let first = enter.clamp(near, far);
        let n = self.field.n_steps();
        for i in 0..n {
            let t = first + i as f32 * step;
            if t > leave || light < LEAST_LIGHT {
                break;
            }
            let point = at(ray.origin, ray.direction, t);
            let outside = (0..3).any(|a| !(bounds[0][a]..=bounds[1][a]).contains(&point[a]));
            if outside || self.field.alpha_mask.as_ref().is_some_and(|mask| !filled(mask, point)) {
                continue;
            }
            count += 1;
            // No step follows the last one.
            let length = if i + 1 < n { step } else { 0.0 };
            let alpha = 1.0 - (-self.density(point, sums) * length).exp();
            let weight = alpha * light;
            if weight > weight_threshold {
                sample(Sample { pixel: 0, weight, point, direction: ray.direction });
            }
            light *= 1.0 - alpha + 1e-10;
        }
        (1.0 - light, count)
    }
}

/// Whether an entry around a point holds something. Beyond the outermost ones lie empty ones.
fn filled(mask: &AlphaMask, point: [f32; 3]) -> bool {
    let [low, high] = mask.bounds;
    let sizes = mask.sizes;
    let grid = [0, 1, 2].map(|a| {
        let unit = (point[a] - low[a]) / (high[a] - low[a]);
        unit * (sizes[a] - 1) as f32
    });
    // Of an entry on which the point lies the next one weighs nothing.
    let around = [0, 1, 2].map(|a| {
        let last = sizes[a] as f32 - 1.0;
        let first = grid[a].floor().max(0.0).min(last + 1.0);
        first as usize..(grid[a].ceil().clamp(-1.0, last) + 1.0) as usize
    });
    let [x, y, z] = around;
    z.clone().any(|z| {
        y.clone().any(|y| x.clone().any(|x| mask.filled[x + sizes[0] * (y + sizes[1] * z)]))
    })
}

impl Volume for Tensors {
    fn trace(&self, rays: &[Ray], pixels: &mut [[f32; 4]]) -> u64 {
        pixels.fill([0.0; 4]);
        // `new` has made one already.
        let Ok(mut shader) = Shader::new(&self.field) else { return 0 };
        let mut sums = vec![0.0; self.field.density.n_products()];
        let mut samples = 0;
        for (pixel, ray) in rays.iter().enumerate() {
            let (opacity, count) = self.march(ray, &mut sums, |sample| {
                shader.push(self.level, Sample { pixel, ..sample }, pixels);
            });
            pixels[pixel][3] = opacity;
            samples += count;
        }
        shader.flush(self.level, pixels);
        for pixel in pixels {
            pixel.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
        }
        samples
    }
}
