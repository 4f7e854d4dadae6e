use glam::Vec3;

use super::grid::Grid;
use super::warp::Mixture;
use super::*;
use crate::network::testing::check;
use crate::photographs::Batch;

/// Rays from all sides through the cube.
fn rays() -> Batch {
    let ray = |i: usize| {
        let angle = i as f32;
        let from = Vec3::new(3.0 * angle.cos(), 3.0 * angle.sin(), 0.2 * angle - 1.0);
        let to = Vec3::new(0.3 * angle.sin(), 0.2, 0.1 * angle.cos());
        Ray { origin: from.to_array(), direction: (to - from).normalize().to_array() }
    };
    let colors = (0..9).map(|i| [0.1 * i as f32, 0.5, 0.3]).collect();
    Batch { rays: (0..9).map(ray).collect(), colors }
}

fn place() -> Place {
    Place { center: [0.0; 3], half: 1.0, depths: [1.0, 5.0], background: [1.0, 0.5, 0.2] }
}

#[test]
fn gradients_are_those_of_the_loss() {
    let config = Config { code: 3, channels: 4, doublings: 1, warp_doublings: 1, maps: 3 };
    let networks = Networks::new(config);
    let mut parameters: Vec<f64> = networks.layout.init(2);
    // Biases too, and maps that are not all the same.
    parameters.iter_mut().zip(0..).for_each(|(p, i)| *p += 0.1 * f64::from(i).sin());
    let batch = rays();
    let of = |parameters: &[f64]| {
        let (volume, tape) = networks.decode(parameters);
        let (loss, _, d) = loss(&volume, &place(), &batch, |i| 0.1 * i as f32);
        (loss, networks.backward(parameters, &tape, d))
    };
    check(&parameters, networks.layout.tensors(), &of(&parameters).1, |p| of(p).0);
}

#[test]
fn opacity_is_added_up_to_one_and_behind_it_nothing_is_seen() {
    let mut volume = Volume { template: Grid::zeros(9, 4), warp: Grid::zeros(9, 3) };
    let mixture_of_nothing = [[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0_f64]];
    let mut weights = Grid::zeros(9, 1);
    weights.values.fill(1.0);
    volume.warp = Mixture { maps: &mixture_of_nothing, weights: &weights }.field(9);
    // Red before x = 0, green behind it, and half as dense as is opaque in one half side.
    for (i, value) in volume.template.values.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let front = i % 9 < 4;
        *value = [f64::from(front), f64::from(!front), 0.0, 0.5];
    }
    let ray = Ray { origin: [-3.0, 0.01, 0.02], direction: [1.0, 0.0, 0.0] };
    let through = volume.march(&place(), &ray, 0.5);
    assert!((through.rgba[3] - 1.0).abs() < 1e-9, "two half sides: {:?}", through.rgba);
    // Twice as dense: the second half is hidden, but for the cell where colours mix.
    volume.template.values.iter_mut().skip(3).step_by(4).for_each(|v| *v = 1.0);
    let [red, green, _, alpha] = volume.march(&place(), &ray, 0.5).rgba;
    assert!((alpha - 1.0).abs() < 1e-9 && red > 0.85 && green < 0.15, "{red} {green} {alpha}");
    // Nothing is there.
    volume.template.values.iter_mut().skip(3).step_by(4).for_each(|v| *v = 0.0);
    assert_eq!(volume.march(&place(), &ray, 0.5).rgba, [0.0; 4]);
    let beside = Ray { origin: [-3.0, 1.5, 0.0], direction: [1.0, 0.0, 0.0] };
    assert_eq!(volume.march(&place(), &beside, 0.5).rgba, [0.0; 4]);
}

/// A small volume that has learnt nothing.
pub(crate) fn small() -> NeuralVolume {
    let config = Config { code: 2, channels: 2, doublings: 1, warp_doublings: 1, maps: 2 };
    NeuralVolume { config, parameters: Networks::new(config).layout.init(4) }
}
