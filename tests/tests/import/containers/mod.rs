//! Checkpoints that torch, numpy and safetensors wrote (`tests/fixtures/checkpoints.py`),
//! sound and damaged.

mod counting;
mod damaged;
mod hostile;
mod npz;
mod numpy;
mod real;
mod safetensors;
mod torch;

use pocketnerf_formats::import::{Checkpoint, Tensor};

fn fixture(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/checkpoints/");
    std::fs::read(format!("{folder}{name}")).unwrap()
}

#[track_caller]
fn tensor<'c, 'a>(checkpoint: &'c Checkpoint<'a>, name: &str) -> &'c Tensor<'a> {
    checkpoint.tensor(name).unwrap_or_else(|| panic!("no {name}"))
}

/// Checks a tensor's shape, and its numbers where all of them are multiples of 1/8.
#[track_caller]
fn expect(checkpoint: &Checkpoint<'_>, name: &str, shape: &[usize], eighths: &[i32]) {
    let tensor = tensor(checkpoint, name);
    assert_eq!(tensor.shape(), shape, "{name}");
    assert_eq!(tensor.len(), eighths.len(), "{name}");
    let expected: Vec<f32> = eighths.iter().map(|&n| n as f32 / 8.0).collect();
    assert_eq!(tensor.to_f32().unwrap(), expected, "{name}");
}
