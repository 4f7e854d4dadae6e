//! Dense layers as sums over one input and one output at a time.

use crate::Error;
use crate::network::{Dense, Mlp};

/// Widest layer that the reference evaluates.
pub const MAX_WIDTH: usize = 512;

/// Why a network is refused.
pub(super) const TOO_WIDE: Error = Error::Limits("the reference evaluates networks up to 512 wide");

/// Values of one layer; those beyond its width are 0.
pub(crate) type Values = [f64; MAX_WIDTH];

/// Refuses a network that is wider than [`MAX_WIDTH`].
pub(super) fn check(network: &Mlp<'_>) -> Result<(), Error> {
    if network.max_width() > MAX_WIDTH {
        return Err(TOO_WIDE);
    }
    Ok(())
}

/// `y = W x + b` per layer, ReLU between layers and none after the last.
///
/// A NaN stays NaN through ReLU, so that it reaches the output and is seen there.
pub(super) fn forward(network: &Mlp<'_>, input: &Values) -> Values {
    let mut x = *input;
    let last = network.layers().len() - 1;
    for (number, layer) in network.layers().iter().enumerate() {
        x = one(layer, &x, number < last);
    }
    x
}

/// One layer; ReLU where `relu`.
pub(crate) fn one(layer: &Dense<'_>, x: &Values, relu: bool) -> Values {
    let n_out = layer.weight.cols();
    let mut y = [0.0; MAX_WIDTH];
    for (o, y) in y.iter_mut().enumerate().take(n_out) {
        if let Some(bias) = layer.bias {
            *y = f64::from(bias.get(o));
        }
        for (i, x) in x.iter().enumerate().take(layer.weight.rows()) {
            *y += f64::from(layer.weight.get(i * n_out + o)) * x;
        }
        if relu && *y < 0.0 {
            *y = 0.0;
        }
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TensorView;
    use crate::reference::testing::{dense, tensor};

    fn values(given: &[f64]) -> Values {
        let mut all = [0.0; MAX_WIDTH];
        all[..given.len()].copy_from_slice(given);
        all
    }

    #[test]
    fn one_layer_by_hand() {
        // Input-major: x0 goes to y by (1, -2, 4), x1 by (10, 20, -30).
        let layer = dense(2, 3, &[1.0, -2.0, 4.0, 10.0, 20.0, -30.0], &[0.5, 0.0, 0.0]);
        let y = forward(&Mlp::new(&[layer]).unwrap(), &values(&[2.0, 0.5]));
        // 0.5 + 2 + 5; -4 + 10; 8 - 15: negative, and no ReLU after the last layer.
        assert_eq!(y[..4], [7.5, 6.0, -7.0, 0.0]);
    }

    #[test]
    fn two_layers_by_hand() {
        let first = dense(1, 2, &[1.0, -1.0], &[1.0, 1.0]);
        let second = Dense { weight: tensor(2, 1, &[3.0, 5.0]), bias: None };
        let network = Mlp::new(&[first, second]).unwrap();
        // x = 3: hidden (4, -2) -> (4, 0), output 12. x = -3: (-2, 4) -> (0, 4), output 20.
        assert_eq!(forward(&network, &values(&[3.0]))[0], 12.0);
        assert_eq!(forward(&network, &values(&[-3.0]))[0], 20.0);
        assert!(forward(&network, &values(&[f64::NAN]))[0].is_nan());
    }

    #[test]
    fn the_scale_of_a_tensor_counts() {
        let stored = tensor(1, 1, &[3.0]);
        let weight =
            TensorView::new(stored.bytes(), stored.dtype(), [1, 1], -2, stored.layout()).unwrap();
        let network = Mlp::new(&[Dense { weight, bias: None }]).unwrap();
        assert_eq!(forward(&network, &values(&[2.0]))[0], 1.5);
    }

    #[test]
    fn too_wide_is_an_error() {
        let of_width = |n: usize| Mlp::new(&[dense(n, 1, &[0.0; 600][..n], &[0.0])]).unwrap();
        assert_eq!(check(&of_width(512)), Ok(()));
        assert!(matches!(check(&of_width(513)), Err(Error::Limits(_))));
    }
}
