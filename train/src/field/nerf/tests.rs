use fearless_simd::{Simd, dispatch};
use pocketnerf_core::field::Activation;
use pocketnerf_core::{AnyField, SimdLevel, reference};

use super::tape::NerfTape;
use super::*;
use crate::field::testing::in_unit_cube;
use crate::field::{Layout, Role};
use crate::random::Random;

/// Density's unit lengths a scene unit.
const SCALE: f32 = 2.0;
/// Samples, two of which fill up a register.
const N: usize = 78;

struct Case {
    config: NerfConfig,
    layout: Layout,
    parameters: Vec<f32>,
    /// Unit points, and directions.
    at: [[[f32; 3]; N]; 2],
    /// How much a sample's density and colour count.
    factors: [[f32; 4]; N],
}

impl Case {
    fn new(config: NerfConfig) -> Self {
        let layout = config.layout();
        let mut parameters = vec![0.0; layout.len()];
        initialize(&config, &layout, 3, &mut parameters);
        let mut random = Random::new(5, [0; 3]);
        // Biases too are to matter.
        for value in &mut parameters {
            *value += 0.02 * random.next_f32();
        }
        // With ReLU, densities below 0 would have no gradient.
        let densities = layout.ranges().iter().filter(|range| {
            range.part.network.ends_with("density") && range.part.role == Role::Bias
        });
        densities.for_each(|range| parameters[range.indices()].fill(0.3));
        let mut draw = || random.next_f32();
        let points = [(); N].map(|()| [draw(), draw(), draw()]);
        let directions = [(); N].map(|()| {
            glam::Vec3::new(draw() - 0.5, draw() - 0.5, draw() - 0.6).normalize().to_array()
        });
        let factors = [(); N].map(|()| [0.1 * draw(), draw(), -draw(), draw()]);
        Self { config, layout, parameters, at: [points, directions], factors }
    }

    fn field<'a>(&self, parameters: &'a [f32], coarse: bool) -> NerfField<'a> {
        let tensor = |range: &crate::field::Range| range.of(parameters);
        let field = self.config.view(&self.layout, SCALE, tensor).unwrap();
        if coarse { field.coarse_field() } else { field }
    }

    /// What core's reference makes of the samples, summed up with their factors.
    fn expected(&self, parameters: &[f32], coarse: bool) -> f64 {
        let model = in_unit_cube(AnyField::Nerf(self.field(parameters, coarse)));
        let [points, directions] = self.at;
        let samples = points.iter().zip(directions).zip(self.factors);
        let each = samples.map(|((point, direction), [sigma, r, g, b])| {
            let (density, rgb) = reference::query_f64(&model, *point, direction).unwrap();
            let [sigma, r, g, b] = [sigma, r, g, b].map(f64::from);
            density * sigma + rgb[0] * r + rgb[1] * g + rgb[2] * b
        });
        each.sum()
    }

    /// The same sum from the tape, and its gradient.
    fn found<S: Simd>(&self, simd: S, coarse: bool) -> (f64, Vec<f32>) {
        let nerf = self.config;
        let mut gradients = NerfGradients::new(&nerf, &self.layout);
        gradients.update(&self.parameters);
        let field = self.field(&self.parameters, coarse);
        let (mut tape, mut work) = (NerfTape::new(&nerf, 96), gradients.work(96));
        let padded = N.next_multiple_of(16);
        let axes = self.at.map(|values| {
            [0, 1, 2].map(|a| {
                let mut axis: Vec<f32> = values.iter().map(|p| p[a]).collect();
                axis.resize(padded, 0.0);
                axis
            })
        });
        let [points, directions] = axes.each_ref().map(|a| a.each_ref().map(|row| &row[..]));
        tape.forward(simd, &field, points, directions);
        let mut sum = 0.0;
        for s in 0..N {
            let raw = tape.raw()[s];
            let sigma = field.sigma(simd, fearless_simd::SimdBase::splat(simd, raw));
            let sigma = fearless_simd::SimdBase::as_slice(&sigma)[0];
            let [f, colors @ ..] = self.factors[s];
            let rgb = tape.color(s);
            sum += f64::from(sigma * f);
            sum += (0..3).map(|c| f64::from(rgb[c] * colors[c])).sum::<f64>();
            let d_raw = d_raw(&field, sigma, f);
            tape.set_gradient(s, d_raw, colors);
        }
        tape.clear_from(N);
        let mut gradient = vec![0.0; self.layout.len()];
        gradients.backward(simd, coarse, &tape, &mut work, &mut gradient);
        (sum, gradient)
    }
}

#[test]
fn gradients_are_those_of_the_reference() {
    let octaves =
        |n, pi| FourierConfig { waves: WavesConfig::Octaves { n, pi }, include_input: true };
    let gaussian = FourierConfig {
        waves: WavesConfig::Gaussian { n: 5, deviation: 1.5 },
        include_input: false,
    };
    let small = NerfConfig {
        positions: octaves(3, false),
        directions: Some(octaves(1, true)),
        depth: 4,
        width: 20,
        skip: 2,
        color_width: 9,
        coarse: true,
        activation: Activation::Softplus,
        muon: false,
        hierarchical: None,
    };
    let cases = [
        small,
        NerfConfig { activation: Activation::Relu, skip: 0, ..small },
        NerfConfig { directions: None, activation: Activation::Exp, width: 40, ..small },
        NerfConfig { positions: gaussian, directions: Some(gaussian), ..small },
        NerfConfig { positions: octaves(0, false), coarse: false, ..small },
    ];
    for nerf in cases {
        let case = Case::new(nerf);
        for coarse in [false, true].into_iter().take(1 + usize::from(nerf.coarse)) {
            for level in SimdLevel::ALL.into_iter().filter_map(|level| level.token().ok()) {
                let (sum, gradient) = dispatch!(level, simd => case.found(simd, coarse));
                let expected = case.expected(&case.parameters, coarse);
                assert!((sum - expected).abs() < 1e-4, "{sum} {expected}");
                check_gradient(&case, coarse, &gradient);
            }
        }
    }
}

/// Random directions through each tensor.
const DIRECTIONS: u64 = 3;

/// Differences along random directions through each tensor.
fn check_gradient(case: &Case, coarse: bool, gradient: &[f32]) {
    for (i, range) in case.layout.ranges().iter().enumerate() {
        let part = range.part;
        let name = if coarse { "coarse" } else { "fine" };
        let own = part.role != Role::Fixed && part.network.starts_with(name);
        if !own {
            // Of the other network, or not trained.
            assert!(gradient[range.indices()].iter().all(|g| *g == 0.0), "{part:?}");
            continue;
        }
        assert!(gradient[range.indices()].iter().any(|g| *g != 0.0), "{part:?}");
        for k in 0..DIRECTIONS {
            let mut random = Random::new(7, [i as u64, k, 0]);
            let direction: Vec<f32> = range.indices().map(|_| random.next_f32() - 0.3).collect();
            let length = direction.iter().map(|d| d * d).sum::<f32>().sqrt();
            // So small that hardly a sample passes a corner of ReLU.
            let h = 1e-6 / length;
            let moved = |h: f32| {
                let mut parameters = case.parameters.clone();
                let own = parameters[range.indices()].iter_mut();
                own.zip(&direction).for_each(|(p, d)| *p += h * d);
                parameters
            };
            let [before, after] = [moved(-h), moved(h)];
            let difference = case.expected(&after, coarse) - case.expected(&before, coarse);
            // Along the way that the rounded parameters went.
            let products = gradient[range.indices()].iter().zip(range.indices());
            let terms = products.map(|(g, i)| f64::from(*g) * f64::from(after[i] - before[i]));
            let (found, size) = terms.fold((0.0, 0.0), |(sum, size), t| (sum + t, size + t.abs()));
            let close = (found - difference).abs() <= 1e-4 * size;
            assert!(close, "{part:?}: {found}, by differences {difference}, of {size}");
        }
    }
}
