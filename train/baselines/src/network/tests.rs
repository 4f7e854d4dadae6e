use ndarray::arr2;

use super::*;

#[test]
fn a_cell_of_memory_by_hand() {
    let mut layout = Layout::default();
    let cell = Lstm::new(&mut layout, 1, 1);
    // Weights of input and memory for the input gate, the forget gate, the candidate and the output
    // gate, then their biases.
    let parameters = [0.5, -1.0, 2.0, 0.25, 0.1, 0.2, -0.3, 0.4, 0.0, 1.0, 0.5, -0.5];
    let state = [arr2(&[[0.6]]), arr2(&[[-0.8]])];
    let (next, _) = cell.forward(&parameters, &arr2(&[[1.5_f64]]).view(), &state);
    let sigmoid = |v: f64| 1.0 / (1.0 + (-v).exp());
    let input = sigmoid(0.5 * 1.5 + 0.1 * 0.6);
    let forget = sigmoid(-1.5 + 0.2 * 0.6 + 1.0);
    let candidate = (2.0 * 1.5 - 0.3 * 0.6 + 0.5_f64).tanh();
    let output = sigmoid(0.25 * 1.5 + 0.4 * 0.6 - 0.5);
    let memory = input * candidate - 0.8 * forget;
    assert!((next[1][[0, 0]] - memory).abs() < 1e-12);
    assert!((next[0][[0, 0]] - output * memory.tanh()).abs() < 1e-12);
}

#[test]
fn a_block_normalises_and_rectifies() {
    let mut layout = Layout::default();
    let block = Mlp::new(&mut layout, 2, 3, 1);
    // The sums are 1, 2 and 6: 2 less, 1 less and 3 more than their mean, with a variance of 14 / 3.
    let parameters = [1.0, 0.0, 2.0, 0.0, 1.0, 1.0, 0.0, 1.0, 3.0];
    let (y, _) = block.forward(&parameters, arr2(&[[1.0, 1.0_f64]]));
    let scale = (14.0_f64 / 3.0 + 1e-5).sqrt();
    assert!(y[[0, 0]] == 0.0 && y[[0, 1]] == 0.0 && (y[[0, 2]] - 3.0 / scale).abs() < 1e-12, "{y}");
}

#[test]
fn adam_by_hand() {
    let mut moments = Moments::new(2);
    let mut parameters = [1.0, -1.0];
    let adam = Adam::default();
    moments.step(adam, 0.1, &mut parameters, &[0.5, 0.0]);
    // The first step goes by the whole rate, against the gradient's sign.
    assert!((parameters[0] - 0.9).abs() < 1e-6 && parameters[1] == -1.0, "{parameters:?}");
    moments.step(adam, 0.1, &mut parameters, &[-0.5, 0.0]);
    // Means 0.9 · 0.05 − 0.05 and (0.999 + 1) · 0.00025, over 1 − 0.9² and 1 − 0.999².
    let expected = 0.9 - 0.1 * (-0.005 / 0.19) / (0.00049975_f64 / 0.001999).sqrt();
    assert!((f64::from(parameters[0]) - expected).abs() < 1e-5, "{parameters:?}");
}

#[test]
fn functions_do_not_overflow() {
    assert_eq!([Real::sigmoid(-200.0_f32), Real::sigmoid(0.0_f32)], [0.0, 0.5]);
    assert_eq!(Real::softplus(200.0_f32), 200.0);
    assert!((Real::softplus(0.0_f64) - 2.0_f64.ln()).abs() < 1e-15);
}
