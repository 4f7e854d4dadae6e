//! A cell of long short-term memory (Hochreiter & Schmidhuber 1997).

use ndarray::{Array2, ArrayView2, Axis, Zip, concatenate, s};

use super::{Dense, Layout, Real};

/// A recurrent cell: from an input and its state to the next state.
#[derive(Clone, Debug)]
pub(crate) struct Lstm {
    gates: Dense,
    hidden: usize,
}

/// Hidden values and cell values of a batch.
pub(crate) type State<T> = [Array2<T>; 2];

/// What the way back needs.
#[derive(Debug)]
pub(crate) struct LstmTape<T> {
    /// Input and hidden values before.
    joined: Array2<T>,
    cell_before: Array2<T>,
    /// Input gate, forget gate, candidate and output gate, after their functions.
    gates: Array2<T>,
    /// tanh of the cell values.
    bounded: Array2<T>,
}

impl Lstm {
    /// Forget gates are open at first.
    pub(crate) fn new(layout: &mut Layout, inputs: usize, hidden: usize) -> Self {
        // Half the variance: gates are no ReLUs.
        let gates = Dense::new(layout, inputs + hidden, 4 * hidden, 0.5_f64.sqrt());
        Self { gates, hidden }
    }

    /// Opens the forget gates.
    pub(crate) fn open<T: Real>(&self, parameters: &mut [T]) {
        let first = self.gates.biases().start + self.hidden;
        parameters[first..first + self.hidden].fill(T::one());
    }

    /// No memory.
    pub(crate) fn empty<T: Real>(&self, n: usize) -> State<T> {
        [Array2::zeros((n, self.hidden)), Array2::zeros((n, self.hidden))]
    }

    pub(crate) fn forward<T: Real>(
        &self,
        parameters: &[T],
        input: &ArrayView2<'_, T>,
        [hidden, cell]: &State<T>,
    ) -> (State<T>, LstmTape<T>) {
        let n = self.hidden;
        let joined = concatenate(Axis(1), &[*input, hidden.view()]).expect("as many rows");
        let mut gates = self.gates.forward(parameters, &joined.view());
        gates.slice_mut(s![.., ..2 * n]).mapv_inplace(Real::sigmoid);
        gates.slice_mut(s![.., 2 * n..3 * n]).mapv_inplace(|v| v.tanh());
        gates.slice_mut(s![.., 3 * n..]).mapv_inplace(Real::sigmoid);
        let [i, f, g, o] = split(&gates, n);
        let next = &i * &g + &f * cell;
        let bounded = next.mapv(|v| v.tanh());
        let out = &o * &bounded;
        let tape = LstmTape { joined, cell_before: cell.clone(), gates, bounded };
        ([out, next], tape)
    }

    /// From the gradients of the state after to those of the input and of the state before; adds
    /// to the parameters' gradient.
    pub(crate) fn backward<T: Real>(
        &self,
        parameters: &[T],
        tape: &LstmTape<T>,
        [d_hidden, d_cell]: &State<T>,
        gradient: &mut [T],
    ) -> (Array2<T>, State<T>) {
        let n = self.hidden;
        let [i, f, g, o] = split(&tape.gates, n);
        let one = T::one();
        let mut d_next = d_hidden * &o;
        Zip::from(&mut d_next).and(&tape.bounded).for_each(|d, t| *d *= one - *t * *t);
        d_next += d_cell;
        let mut d = Array2::zeros(tape.gates.raw_dim());
        let sigmoid = |gate: &ArrayView2<'_, T>| gate.mapv(|v| v * (one - v));
        d.slice_mut(s![.., ..n]).assign(&(&d_next * &g * sigmoid(&i)));
        d.slice_mut(s![.., n..2 * n]).assign(&(&d_next * &tape.cell_before * sigmoid(&f)));
        d.slice_mut(s![.., 2 * n..3 * n]).assign(&(&d_next * &i * g.mapv(|v| one - v * v)));
        d.slice_mut(s![.., 3 * n..]).assign(&(d_hidden * &tape.bounded * sigmoid(&o)));
        let d_joined = self.gates.backward(parameters, &tape.joined.view(), &d.view(), gradient);
        let inputs = d_joined.ncols() - n;
        let d_input = d_joined.slice(s![.., ..inputs]).to_owned();
        let d_before = d_joined.slice(s![.., inputs..]).to_owned();
        (d_input, [d_before, d_next * f])
    }
}

/// The four gates.
fn split<T>(gates: &Array2<T>, n: usize) -> [ArrayView2<'_, T>; 4] {
    [0, 1, 2, 3].map(|k| gates.slice(s![.., k * n..(k + 1) * n]))
}
