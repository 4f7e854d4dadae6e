use pocketnerf_core::Ray;

use super::*;
use crate::network::testing::check;

/// Rays from all sides at what lies around the origin.
fn rays() -> Vec<Ray> {
    let ray = |i: usize| {
        let angle = i as f32;
        let from = glam::Vec3::new(3.0 * angle.cos(), 3.0 * angle.sin(), 0.3 * angle - 1.0);
        let to = glam::Vec3::new(0.1 * angle.sin(), 0.2, 0.1);
        Ray { origin: from.to_array(), direction: (to - from).normalize().to_array() }
    };
    (0..7).map(ray).collect()
}

#[test]
fn gradients_are_those_of_the_loss() {
    let place = Place { center: [0.0; 3], half: 1.0, depths: [1.0, 5.0], background: [1.0; 3] };
    let networks = Networks::new(Config { width: 8, hidden: 3, steps: 3 });
    let mut parameters: Vec<f64> = networks.layout.init(1);
    // Biases too, and steps in both directions.
    parameters.iter_mut().zip(0..).for_each(|(p, i)| *p += 0.3 * f64::from(i).sin());
    let rays = rays();
    let targets = Array2::from_shape_fn((rays.len(), 3), |(i, c)| 0.1 * (i + c) as f64);
    let loss = |parameters: &[f64]| {
        let pass = networks.forward(parameters, &place, &rays);
        let error = (&pass.colors - &targets).mapv(|d| d * d).sum();
        error + 0.7 * Networks::penalty(&pass)
    };
    let pass = networks.forward(&parameters, &place, &rays);
    assert!(Networks::penalty(&pass) > 0.0, "no depth is negative");
    let mut gradient = vec![0.0; networks.len()];
    networks.backward(&parameters, &pass, &((&pass.colors - &targets) * 2.0), 0.7, &mut gradient);
    check(&parameters, networks.layout.tensors(), &gradient, loss);
}

/// Small networks that have learnt nothing.
pub(crate) fn small() -> Srn {
    let config = Config { width: 6, hidden: 3, steps: 2 };
    let networks = Networks::new(config);
    Srn { config, parameters: networks.layout.init(4) }
}
