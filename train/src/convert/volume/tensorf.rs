//! Rays through a model of TensoRF, as `TensorBase.forward` renders them.

use fearless_simd::Level;
use pocketnerf_core::{Error, Ray, Space};
use pocketnerf_formats::import::volume::{AlphaMask, TensoRf};

use super::factors::{Place, products};
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
        // What is no number is nothing.
        (value * self.field.distance_scale).max(0.0)
    }

    /// Marches along a ray: what of it has a colour goes to `sample`; its opacity.
    fn march(&self, ray: &Ray, sums: &mut [f32], mut sample: impl FnMut(Sample)) -> (f32, u64) {
        let TensoRf { near_far: [near, far], step, weight_threshold, .. } = self.field;
        let [min, max] = self.field.bounds;
        let space = Space::Box { min, max };
        let Some([enter, leave]) = space.intersect(ray, near, f32::INFINITY) else {
            return (0.0, 0);
        };
        let (mut light, mut count) = (1.0f32, 0);
        let first = enter.min(far);
        let n = self.field.n_steps();
        for i in 0..n {
            let t = first + i as f32 * step;
            if t > leave || light < LEAST_LIGHT {
                break;
            }
            let point = [0, 1, 2].map(|a| ray.origin[a] + t * ray.direction[a]);
            let masked = self.field.alpha_mask.as_ref().is_some_and(|mask| !filled(mask, point));
            if masked || !space.contains(point) {
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
    z.clone().any(|z| y.clone().any(|y| x.clone().any(|x| mask.holds([x, y, z]))))
}

impl Volume for Tensors {
    fn trace(&self, rays: &[Ray], pixels: &mut [[f32; 4]]) -> u64 {
        pixels.fill([0.0; 4]);
        let mut shader = Shader::new(&self.field).expect("`new` has made one");
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
            for value in pixel {
                // What is no number is nothing.
                *value = if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
            }
        }
        samples
    }
}
