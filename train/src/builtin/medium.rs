//! What light passes through: tinted glass and fog, with exact transmittance.
//!
//! Each has one encoded colour, and densities whose integral along a ray has a closed
//! form. Layers are composited in encoded values, as a radiance field does, so that a
//! field could show them exactly.

use super::shapes::Shape;
use glam::DVec3;
use pocketnerf_core::math;
use std::f64::consts::LN_2;

/// Where a medium is, and how its density varies there.
#[derive(Clone, Copy, Debug)]
pub(super) enum Matter {
    /// The same density everywhere in a solid.
    Glass(Shape),
    /// A soft ellipsoid: the density falls as (1 − ρ²)² from the middle to its edge, ρ
    /// being the distance from the middle in radii.
    Fog { center: DVec3, radii: DVec3 },
}

/// Something that is neither opaque nor empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Medium {
    pub(super) matter: Matter,
    /// The density, in the middle of a fog; 1 / scene unit.
    pub(super) sigma: f64,
    /// Encoded.
    pub(super) colour: DVec3,
}

/// A ray's way through a medium.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// Where it begins and ends, distances along the ray.
    from: f64,
    to: f64,
    sigma: f64,
    /// Of a fog: distance to the middle of the whole way, half its length, and 1 − ρ²
    /// divided by the difference of squares of half the length and the distance from there.
    soft: Option<[f64; 3]>,
    pub(super) colour: DVec3,
}

impl Medium {
    /// Glass of which a layer as thick as `thickness` has the opacity `alpha`.
    pub(super) fn glass(shape: Shape, thickness: f64, alpha: f64, colour: DVec3) -> Self {
        let sigma = -f64::from(math::ln((1.0 - alpha) as f32)) / thickness;
        Self { matter: Matter::Glass(shape), sigma, colour }
    }

    /// The ray's way through it, at most as far as `until`.
    pub(super) fn passage(&self, origin: DVec3, direction: DVec3, until: f64) -> Option<Passage> {
        let shape = match self.matter {
            Matter::Glass(shape) => shape,
            Matter::Fog { center, radii } => Shape::Ellipsoid { center, radii },
        };
        let [enter, leave] = shape.span(origin, direction)?;
        let soft = match self.matter {
            Matter::Glass(_) => None,
            Matter::Fog { radii, .. } => {
                let scale = (direction / radii).length_squared();
                Some([0.5 * (enter + leave), 0.5 * (leave - enter), scale])
            }
        };
        let (from, to) = (enter.max(0.0), leave.min(until));
        let Self { sigma, colour, .. } = *self;
        (from < to).then_some(Passage { from, to, sigma, soft, colour })
    }

    /// Centre and radius of a ball around it.
    pub(super) fn bound(&self) -> (DVec3, f64) {
        match self.matter {
            Matter::Glass(shape) => shape.bound(0),
            Matter::Fog { center, radii } => (center, radii.max_element()),
        }
    }
}

impl Passage {
    /// Where it begins and ends.
    #[cfg(test)]
    pub(super) fn span(&self) -> [f64; 2] {
        [self.from, self.to]
    }

    /// 1 − transmittance.
    pub(super) fn opacity(&self) -> f64 {
        1.0 - f64::from(math::exp(-self.depth_at(self.to) as f32))
    }

    /// The integral of the density up to distance `t`.
    fn depth_at(&self, t: f64) -> f64 {
        let Some([middle, half, scale]) = self.soft else {
            return self.sigma * (t - self.from);
        };
        // The integral of (half² − s²)², s being measured from the middle.
        let integral = |t: f64| {
            let (s, h2) = (t - middle, half * half);
            let s2 = s * s;
            s * (h2 * h2 - s2 * (2.0 / 3.0 * h2 - 0.2 * s2))
        };
        self.sigma * scale * scale * (integral(t) - integral(self.from))
    }
}

/// Where transmittance falls to one half along a ray through `layers`, in their order.
pub(super) fn half_way(layers: &[Passage]) -> Option<f64> {
    let mut left = LN_2;
    for layer in layers {
        let depth = layer.depth_at(layer.to);
        if depth >= left {
            let [mut low, mut high] = [layer.from, layer.to];
            // Distances are given in f32: 40 halvings are more than enough.
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                *(if layer.depth_at(middle) < left { &mut low } else { &mut high }) = middle;
            }
            return Some(high);
        }
        left -= depth;
    }
    None
}

/// Orders layers by where they begin.
pub(super) fn sort(layers: &mut [Passage]) {
    layers.sort_by(|a, b| a.from.total_cmp(&b.from));
}

/// Colour (premultiplied) and opacity of `layers` before what lies behind them.
pub(super) fn composite(layers: &[Passage], (colour, alpha): (DVec3, f64)) -> (DVec3, f64) {
    layers.iter().rev().fold((colour, alpha), |(colour, alpha), layer| {
        let opacity = layer.opacity();
        let through = 1.0 - opacity;
        (layer.colour * opacity + colour * through, opacity + alpha * through)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed form agrees with a sum over many steps, also where a surface ends the ray.
    #[test]
    fn fog_is_integrated_exactly() {
        let center = DVec3::new(0.1, -0.2, 0.3);
        let radii = DVec3::new(0.9, 0.7, 0.5);
        let fog = Medium { matter: Matter::Fog { center, radii }, sigma: 3.0, colour: DVec3::ONE };
        let origin = DVec3::new(3.0, 2.0, 1.0);
        let direction = (DVec3::new(0.2, -0.1, 0.2) - origin).normalize();
        for until in [3.4, 3.7, f64::INFINITY] {
            let passage = fog.passage(origin, direction, until).unwrap();
            let n = 100_000;
            let step = (passage.to - passage.from) / f64::from(n);
            let sum: f64 = (0..n)
                .map(|i| {
                    let p = origin + direction * (passage.from + (f64::from(i) + 0.5) * step);
                    let inside = 1.0 - ((p - center) / radii).length_squared();
                    3.0 * inside * inside * step
                })
                .sum();
            let depth = passage.depth_at(passage.to);
            assert!((sum - depth).abs() < 1e-8, "{sum} {depth}");
            assert!((passage.opacity() - (1.0 - (-sum).exp())).abs() < 1e-6);
            if let Some(t) = half_way(&[passage]) {
                assert!((passage.depth_at(t) - LN_2).abs() < 1e-9);
            }
        }
    }
}
