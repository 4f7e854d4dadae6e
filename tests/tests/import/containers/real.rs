//! Trained checkpoints, where `POCKETNERF_DATA` says that they lie. The expected numbers
//! are what torch itself reads from them.

use pocketnerf_formats::import::{Checkpoint, Container};

use super::tensor;

fn data(file: &str) -> Option<Vec<u8>> {
    let file = pocketnerf_tests::data()?.join("weights/nerf-pytorch-4x128").join(file);
    Some(std::fs::read(file).unwrap())
}

/// A network of nerf-pytorch with four layers of 128, its positions encoded in so many
/// numbers.
fn shapes(encoded: usize) -> Vec<(&'static str, Vec<usize>)> {
    vec![
        ("layer1.weight", vec![128, encoded]),
        ("layer1.bias", vec![128]),
        ("layers_xyz.0.weight", vec![128, 128]),
        ("layers_xyz.0.bias", vec![128]),
        ("layers_xyz.1.weight", vec![128, 128]),
        ("layers_xyz.1.bias", vec![128]),
        ("layers_xyz.2.weight", vec![128, 128]),
        ("layers_xyz.2.bias", vec![128]),
        ("layers_dir.0.weight", vec![64, 155]),
        ("layers_dir.0.bias", vec![64]),
        ("fc_alpha.weight", vec![1, 128]),
        ("fc_alpha.bias", vec![1]),
        ("fc_rgb.weight", vec![3, 64]),
        ("fc_rgb.bias", vec![3]),
        ("fc_feat.weight", vec![128, 128]),
        ("fc_feat.bias", vec![128]),
    ]
}

fn check(checkpoint: &Checkpoint<'_>, encoded: usize) {
    assert_eq!(checkpoint.container(), Container::TorchLegacy);
    assert_eq!(checkpoint.names().count(), 97);
    let mut names = checkpoint.names();
    for network in ["model_coarse_state_dict", "model_fine_state_dict"] {
        for (layer, shape) in shapes(encoded) {
            let name = format!("{network}.{layer}");
            assert_eq!(names.next(), Some(name.as_str()));
            assert_eq!(tensor(checkpoint, &name).shape(), shape);
        }
    }
}

#[test]
fn lego() {
    let Some(bytes) = data("lego/checkpoint199999.ckpt") else { return };
    let checkpoint = Checkpoint::read(&bytes).unwrap();
    check(&checkpoint, 63);
    assert_eq!(checkpoint.number("iter"), Some(199_999.0));
    assert_eq!(checkpoint.number("psnr"), Some(21.400_112_721_807_083));
    let first = tensor(&checkpoint, "model_coarse_state_dict.layer1.weight").to_f32().unwrap();
    assert_eq!((first[0], first[5 * 63 + 7]), (-0.391_181_77, 0.971_542_5));
    let sum: f64 = first.iter().map(|&weight| f64::from(weight)).sum();
    assert!((sum - 64.245_405_760_464_54).abs() < 1e-9, "{sum}");
    let bias = tensor(&checkpoint, "model_fine_state_dict.fc_rgb.bias").to_f32().unwrap();
    assert_eq!(bias, [-0.174_236_45, -0.163_237_02, -0.291_205_05]);
}

#[test]
fn fern() {
    let Some(bytes) = data("fern/checkpoint249999.ckpt") else { return };
    let checkpoint = Checkpoint::read(&bytes).unwrap();
    check(&checkpoint, 39);
    assert_eq!(checkpoint.number("iter"), Some(249_999.0));
    let first = tensor(&checkpoint, "model_coarse_state_dict.layer1.weight").to_f32().unwrap();
    assert_eq!((first[0], first[5 * 39 + 7]), (1.305_821_7, 0.476_173));
    let bias = tensor(&checkpoint, "model_fine_state_dict.fc_rgb.bias").to_f32().unwrap();
    assert_eq!(bias, [0.098_167_524, 0.071_181_92, -0.192_006_47]);
}
