//! Gradients against finite differences, and grids that become finer.

use fearless_simd::Level;
use pocketnerf_core::{Model, SimdLevel, reference};

use super::*;
use crate::field::testing::in_unit_cube;
use crate::random::Random;
use crate::trainer::pack;

/// Samples of a group.
const SAMPLES: usize = 300;
/// The place of a sample, its direction, and what more of the logarithm of its density and of its
/// colour adds to the loss.
type Sample = ([f32; 3], [f32; 3], [f32; 4]);
type Samples = Vec<Sample>;

/// A ball of cells in a grid of so many voxels.
fn config(resolution: u32, sh_degree: u32) -> PlenoxelsConfig {
    let n = 16;
    let inside = |cell: &u32| {
        let square = |c: u32| (2 * c + 1).abs_diff(n).pow(2);
        square(cell % n) + square(cell / n % n) + square(cell / (n * n)) < n * n / 2
    };
    let (coarse, fine) = pack(n, (0..n.pow(3)).filter(inside)).unwrap();
    let cells = Occupancy::new(n, 1, &coarse, &fine).unwrap();
    let whole = PlenoxelsConfig::new(resolution, sh_degree);
    whole.within(&cells)
}

/// Whole numbers of a small unit, so that differences of them are exact; colours stay between 0
/// and 1. The brick that holds nothing is 0.
fn values(layout: &Layout, random: &mut Random) -> Vec<f32> {
    let mut values: Vec<f32> =
        (0..layout.len()).map(|_| (random.below(256) as f32 - 128.0) / 2048.0).collect();
    let n_values = layout.tables()[0].shape[1];
    values[..64 * n_values].fill(0.0);
    values
}

fn samples(random: &mut Random, n: usize) -> Samples {
    let mut three = || [0; 3].map(|_| random.next_f32());
    (0..n)
        .map(|_| {
            let direction = glam::Vec3::from(three().map(|v| v - 0.5)).normalize();
            let ([a, b, c], [d, ..]) = (three(), three());
            (three(), direction.into(), [a, b, c, d].map(|v| v - 0.5))
        })
        .collect()
}

/// By the oracle, in f64.
fn loss(field: &dyn TrainableField, values: &[f32], samples: &Samples) -> f64 {
    let model = in_unit_cube(field.view(values).unwrap());
    let of = |(point, direction, [density, colors @ ..]): &Sample| {
        let (sigma, rgb) = reference::query_f64(&model, *point, *direction).unwrap();
        let colors = colors.iter().zip(rgb).map(|(d, c)| f64::from(*d) * c).sum::<f64>();
        f64::from(*density) * sigma.ln() + colors
    };
    samples.iter().map(of).sum()
}

/// Through the way back, two groups of samples.
fn gradient(field: &mut dyn TrainableField, values: &[f32], samples: &Samples) -> Vec<f32> {
    let level: Level = SimdLevel::detect().token().unwrap();
    field.prepare(values, 2);
    for (group, samples) in samples.chunks(SAMPLES).enumerate() {
        let row = |of: &dyn Fn(&Sample) -> f32| -> Vec<f32> {
            let padded = samples.len().next_multiple_of(32) - samples.len();
            samples.iter().map(of).chain(std::iter::repeat_n(0.0, padded)).collect()
        };
        let points = [0, 1, 2].map(|a| row(&|sample| sample.0[a]));
        let directions = [0, 1, 2].map(|a| row(&|sample| sample.1[a]));
        let (sigma, gray) = (vec![1.0; samples.len()], vec![0.5; samples.len()]);
        let gradients: Vec<f32> =
            samples.iter().flat_map(|(.., d)| d.iter().copied().chain([0.0; 12])).collect();
        let context = Context { level, parameters: values, stopwatch: None };
        field.back(group, context).samples(&super::super::SampleGradients {
            len: samples.len(),
            points: points.each_ref().map(|row| &row[..]),
            directions: directions.each_ref().map(|row| &row[..]),
            sigma: &sigma,
            colors: [&gray; 3],
            gradients: &gradients,
            row_len: 16,
        });
    }
    field.gradient(level, values)
}

#[test]
fn gradients_are_differences() {
    for (resolution, sh_degree) in [(16, 1), (24, 2), (40, 3)] {
        let mut random = Random::new(7, [resolution.into(), 0, 0]);
        let config = config(resolution, sh_degree);
        let mut field = config.build(1.0);
        let n_values = config.n_values();
        let values = values(field.layout(), &mut random);
        let samples = samples(&mut random, 2 * SAMPLES);
        let found = gradient(&mut *field, &values, &samples);
        // What counts: the fast path finds places in f32.
        let touched: Vec<usize> = (0..found.len()).filter(|i| found[*i].abs() > 0.01).collect();
        assert!(touched.len() > 1000, "{}", touched.len());
        assert!(touched.iter().all(|i| *i >= 64 * n_values), "the brick that holds nothing");
        let step = 1.0 / 1024.0;
        // Some by themselves, then in random directions all that are read.
        let mut directions: Vec<Vec<(usize, f32)>> =
            (0..24).map(|_| vec![(touched[random.below(touched.len())], 1.0)]).collect();
        directions.extend((0..4).map(|_| {
            let sign = |i: &usize| (*i, if random.below(2) == 0 { 1.0 } else { -1.0 });
            touched.iter().map(sign).collect()
        }));
        for direction in directions {
            let moved = |times: f32| {
                let mut values = values.clone();
                direction.iter().for_each(|(i, sign)| values[*i] += times * sign * step);
                loss(&*field, &values, &samples)
            };
            let expected = (moved(1.0) - moved(-1.0)) / f64::from(2.0 * step);
            let sum: f64 =
                direction.iter().map(|(i, sign)| f64::from(found[*i]) * f64::from(*sign)).sum();
            let size: f64 = direction.iter().map(|(i, _)| f64::from(found[*i]).powi(2)).sum();
            let off = (sum - expected).abs();
            assert!(off <= 1e-4 * size.sqrt(), "{resolution} {sh_degree}: {sum} {expected}");
        }
    }
}

#[test]
fn a_colour_that_is_cut_off_is_brought_back_and_no_further() {
    let config = config(16, 1);
    let mut field = config.build(1.0);
    let values = vec![0.0; field.layout().len()];
    field.prepare(&values, 1);
    let level = SimdLevel::detect().token().unwrap();
    let context = Context { level, parameters: &values, stopwatch: None };
    let zeros = [0.0; 32];
    let middle = [0.5; 32];
    // Black, white and grey, each of which is to become darker, then brighter.
    let mut gradients = [0.0; 32];
    gradients[1..4].copy_from_slice(&[1.0; 3]);
    gradients[17..20].copy_from_slice(&[-1.0; 3]);
    field.back(0, context).samples(&super::super::SampleGradients {
        len: 2,
        points: [&middle; 3],
        directions: [&zeros, &zeros, &middle],
        sigma: &[1.0; 2],
        colors: [&[0.0; 2], &[1.0; 2], &[0.5; 2]],
        gradients: &gradients,
        row_len: 16,
    });
    let found = field.gradient(level, &values);
    let sum = |color: usize| -> f32 { found.iter().skip(1 + color).step_by(4).sum() };
    // The constant harmonic.
    assert!((sum(0) + 0.282_094_8).abs() < 1e-6 && (sum(1) - 0.282_094_8).abs() < 1e-6);
    assert_eq!(sum(2), 0.0);
}

#[test]
fn a_finer_grid_holds_the_same_scene() {
    let mut random = Random::new(3, [0; 3]);
    let old = PlenoxelsConfig { last_resolution: 48, ..config(24, 2) };
    let field = old.build(1.0);
    let values = values(field.layout(), &mut random);
    let n = 16;
    let (coarse, fine) = pack(n, 0..n * n * n).unwrap();
    let cells = Occupancy::new(n, 1, &coarse, &fine).unwrap();
    assert!(old.is_due_to_grow(1.0));
    let grown = FieldKind::grown(&old, 1.0, &cells, [&values, &values]).unwrap();
    assert_eq!(grown.parameters, grown.square);
    let finer = grown.field.kind().build(1.0);
    let (before, after) = (field.view(&values).unwrap(), finer.view(&grown.parameters).unwrap());
    let (before, after) = (in_unit_cube(before), in_unit_cube(after));
    assert_eq!(after.field.finest_detail(), 1.0 / 48.0);
    for (point, direction, _) in samples(&mut random, 1000) {
        let of = |model: &Model<'_>| reference::query_f64(model, point, direction).unwrap();
        let ((sigma, rgb), (fine_sigma, fine_rgb)) = (of(&before), of(&after));
        assert!((fine_sigma / sigma - 1.0).abs() < 1e-5, "{point:?}: {sigma} {fine_sigma}");
        assert!((0..3).all(|c| (rgb[c] - fine_rgb[c]).abs() < 1e-6), "{rgb:?} {fine_rgb:?}");
    }
}

#[test]
fn shapes_come_back_from_models() {
    let config = PlenoxelsConfig { last_resolution: 64, ..config(32, 2) };
    let field = config.build(2.0);
    let values = vec![0.25; field.layout().len()];
    let view = field.view(&values).unwrap();
    let section = FieldKind::section(&config).unwrap();
    assert_eq!(FieldConfig::of(&view, Some(&section)), Ok(FieldConfig::Plenoxels(config.clone())));
    assert_eq!(FieldConfig::of(&view, None), Err(super::super::Unusable::NoSection));
    for damaged in [&section[1..], &section[4..], &[3, 0, 0, 0, 64, 0, 0, 0]] {
        assert_eq!(FieldConfig::of(&view, Some(damaged)), Err(super::super::Unusable::Section));
    }
}

#[test]
fn resolutions_double_up_to_the_last() {
    let of = |last: u32| PlenoxelsConfig::new(last, 1).resolution;
    assert_eq!(
        [of(16), of(128), of(200), of(256), of(504), of(512)],
        [16, 128, 200, 128, 252, 128]
    );
    let at = |resolution, progress| {
        let config =
            PlenoxelsConfig { resolution, last_resolution: 512, ..PlenoxelsConfig::default() };
        config.due(progress).map(|config| config.resolution)
    };
    assert_eq!([at(128, 0.0), at(128, 0.2), at(128, 0.31)], [None, Some(256), Some(512)]);
    assert_eq!([at(256, 0.2), at(256, 0.5), at(512, 1.0)], [None, Some(512), None]);
}

#[test]
fn a_scene_that_fills_too_many_bricks_has_fewer_voxels_and_says_so() {
    let n = 16;
    let (coarse, fine) = pack(n, 0..n * n * n).unwrap();
    let cells = Occupancy::new(n, 1, &coarse, &fine).unwrap();
    let whole = PlenoxelsConfig::new(256, 2);
    assert_eq!((whole.resolution, FieldKind::doubt(&whole)), (128, None));
    let begun = whole.within(&cells);
    assert_eq!(
        (begun.resolution, begun.last_resolution, FieldKind::doubt(&begun)),
        (128, 256, None)
    );
    // 65 bricks along an axis are too many, and 49 too.
    let values = vec![0.0; begun.layout().len()];
    let grown = FieldKind::grown(&begun, 1.0, &cells, [&values, &values]).unwrap();
    let FieldConfig::Plenoxels(grown) = grown.field else { unreachable!() };
    assert_eq!((grown.resolution, grown.last_resolution), (144, 144));
    assert!(!grown.is_due_to_grow(1.0));
    let doubt = FieldKind::doubt(&grown).unwrap();
    assert!(doubt.contains("144 voxels along its longest side, expected 256"), "{doubt}");
}
