use pocketnerf_core::{SimdLevel, reference};

use super::*;
use crate::field::testing::in_unit_cube;
use crate::field::{FourierConfig, NerfConfig, SampleGradients, WavesConfig};
use crate::random::Random;

/// Samples, more than go back together, and no whole number of blocks.
const N: usize = 1500;

fn config() -> DerfConfig {
    let octaves =
        |n| FourierConfig { waves: WavesConfig::Octaves { n, pi: false }, include_input: true };
    let head = NerfConfig {
        positions: octaves(2),
        directions: Some(octaves(1)),
        depth: 3,
        width: 12,
        skip: 2,
        color_width: 7,
        ..DerfConfig::default().head
    };
    let sites = vec![[0.2, 0.3, 0.4], [0.7, 0.6, 0.5], [0.5, 0.1, 0.9]];
    DerfConfig { n_heads: 3, head, sites }
}

/// What core's oracle makes of samples, summed up with their factors.
fn expected(
    field: &dyn TrainableField,
    parameters: &[f32],
    at: &[[[f32; 3]; 2]],
    factors: &[[f32; 4]],
) -> f64 {
    let model = in_unit_cube(field.view(parameters).unwrap());
    let each = at.iter().zip(factors).map(|([point, direction], factors)| {
        let (density, rgb) = reference::query_f64(&model, *point, *direction).unwrap();
        let [log, r, g, b] = factors.map(f64::from);
        density.ln() * log + rgb[0] * r + rgb[1] * g + rgb[2] * b
    });
    each.sum()
}

/// Each parameter's derivative against the difference that the oracle sees.
#[test]
fn gradients_are_those_of_the_oracle() {
    let mut field = config().build(2.0);
    let mut parameters = vec![0.0; field.layout().len()];
    field.initialize(3, &mut parameters);
    let mut random = Random::new(5, [0; 3]);
    let mut draw = || random.next_f32();
    let at: Vec<_> = (0..N)
        .map(|_| {
            let direction = glam::Vec3::new(draw() - 0.5, draw() - 0.5, draw() - 0.6).normalize();
            [[draw(), draw(), draw()], direction.to_array()]
        })
        .collect();
    let factors: Vec<_> = (0..N).map(|_| [0.1 * draw(), draw(), -draw(), draw()]).collect();
    let padded = N.next_multiple_of(32);
    let row = |which: usize, axis: usize| {
        let mut row: Vec<f32> = at.iter().map(|at| at[which][axis]).collect();
        row.resize(padded, 0.0);
        row
    };
    let rows: Vec<Vec<f32>> = (0..6).map(|i| row(i / 3, i % 3)).collect();
    for level in SimdLevel::ALL.into_iter().filter_map(|level| level.token().ok()) {
        field.set(level, &parameters);
        field.prepare(&parameters, 2);
        // What is forwards, from core's kernels.
        let AnyField::Derf(view) = field.view(&parameters).unwrap() else { panic!("another kind") };
        let sigma: Vec<f32> = at
            .iter()
            .map(|[point, direction]| {
                let mut nearest = [0.0];
                view.nearest([&point[..1], &point[1..2], &point[2..]], &mut nearest);
                let head = AnyField::Nerf(view.head(nearest[0] as usize).unwrap());
                density(head, *point, *direction)
            })
            .collect();
        let mut gradients = vec![0.0; N * 16];
        for (row, factors) in gradients.chunks_exact_mut(16).zip(&factors) {
            row[..4].copy_from_slice(factors);
        }
        // Two groups, one with a part of the samples each.
        for (group, range) in [(0, 0..N / 2), (1, N / 2..N)] {
            let context = Context { level, parameters: &parameters, stopwatch: None };
            let mut back = field.back(group, context);
            let rows: Vec<Vec<f32>> = rows
                .iter()
                .map(|row| {
                    let mut own = row[range.clone()].to_vec();
                    own.resize(own.len().next_multiple_of(32), 0.0);
                    own
                })
                .collect();
            back.samples(&SampleGradients {
                len: range.len(),
                points: [&rows[0], &rows[1], &rows[2]],
                directions: [&rows[3], &rows[4], &rows[5]],
                sigma: &sigma[range.clone()],
                colors: [&[], &[], &[]],
                gradients: &gradients[16 * range.start..],
                row_len: 16,
            });
        }
        let gradient = field.gradient(level, &parameters);
        let head_len = gradient.len() / 3;
        for head in 0..3 {
            let own = &gradient[head * head_len..][..head_len];
            assert!(own.iter().any(|g| *g != 0.0), "head {head} learns nothing");
        }
        let ranges = field.layout().ranges().to_vec();
        for (i, range) in ranges.iter().enumerate() {
            let mut random = Random::new(7, [i as u64, 0, 0]);
            let direction: Vec<f32> = range.indices().map(|_| random.next_f32() - 0.3).collect();
            let length = direction.iter().map(|d| d * d).sum::<f32>().sqrt();
            let moved = |h: f32| {
                let mut parameters = parameters.clone();
                let own = parameters[range.indices()].iter_mut();
                own.zip(&direction).for_each(|(p, d)| *p += h / length * d);
                parameters
            };
            let [before, after] = [moved(-1e-5), moved(1e-5)];
            let difference = expected(&*field, &after, &at, &factors)
                - expected(&*field, &before, &at, &factors);
            // Along the way that the rounded parameters went.
            let products = gradient[range.indices()].iter().zip(range.indices());
            let terms = products.map(|(g, i)| f64::from(*g) * f64::from(after[i] - before[i]));
            let (found, size) = terms.fold((0.0, 0.0), |(sum, size), t| (sum + t, size + t.abs()));
            let close = (found - difference).abs() <= 2e-3 * size;
            assert!(close, "{:?}: {found} {difference}", range.part);
        }
    }
}

/// A density as the oracle has it.
fn density(field: AnyField<'_>, point: [f32; 3], direction: [f32; 3]) -> f32 {
    let model = in_unit_cube(field);
    reference::query(&model, point, direction).unwrap().sigma
}

/// A point is asked of the head whose site is nearest.
#[test]
fn a_head_is_asked_for_its_own_samples() {
    let field = config().build(2.0);
    let mut parameters = vec![0.0; field.layout().len()];
    field.initialize(3, &mut parameters);
    let AnyField::Derf(view) = field.view(&parameters).unwrap() else { panic!("another kind") };
    let [x, y, z] = [[0.21, 0.69, 0.5], [0.3, 0.6, 0.1], [0.4, 0.5, 0.9]];
    let mut nearest = [9.0; 3];
    view.nearest([&x, &y, &z], &mut nearest);
    assert_eq!(nearest, [0.0, 1.0, 2.0]);
    let [a, b] = [0, 1].map(|head| {
        density(AnyField::Nerf(view.head(head).unwrap()), [0.2, 0.3, 0.4], [0.0, 0.0, 1.0])
    });
    assert!((a - b).abs() > 1e-6, "heads differ");
    assert_eq!(a, density(AnyField::Derf(view), [0.2, 0.3, 0.4], [0.0, 0.0, 1.0]));
    assert!(view.head(3).is_err());
}
