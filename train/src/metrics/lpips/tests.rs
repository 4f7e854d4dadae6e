//! Against the package lpips, by weights that follow from a formula and by trained ones.

use crate::picture::image_file;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::network::Shape;
use super::*;
use crate::metrics::patterns::{Make, patterns, soft};

const FILE: &str = "weights.npz";

/// A tensor of a file.
struct Written {
    name: String,
    shape: Vec<usize>,
    values: Vec<f32>,
}

/// -1 to 1, by a hash of the index: `numbers` of `tests/fixtures/lpips_reference.py`.
fn numbers(seed: usize, n: usize) -> impl Iterator<Item = f64> {
    (0..n as u32).map(move |i| {
        let mut x = i.wrapping_add((seed as u32).wrapping_mul(0x9e37_79b9));
        x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
        x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
        x ^= x >> 16;
        f64::from(x >> 8) / f64::from(1 << 23) - 1.0
    })
}

/// The weights of `lpips_reference.py` under torch's names, in torch's layout.
fn torch_weights(network: &Network) -> Vec<Written> {
    let mut tensors = Vec::new();
    let mut add = |name, shape: Vec<usize>, values: Vec<f64>| {
        let values = values.into_iter().map(|value| value as f32).collect();
        tensors.push(Written { name, shape, values });
    };
    for (i, Shape { side, from, to, .. }) in network.shapes().enumerate() {
        let covered = from * side * side;
        let scale = (6.0_f64 / covered as f64).sqrt();
        let kernel = numbers(2 * i, to * covered).map(|v| v * scale);
        add(format!("net.slice.{i}.weight"), vec![to, from, side, side], kernel.collect());
        let bias = numbers(2 * i + 1, to).map(|v| v * 0.1);
        add(format!("net.slice.{i}.bias"), vec![to], bias.collect());
    }
    for (i, channels) in network.taps().enumerate() {
        let head = numbers(100 + i, channels).map(|v| v.abs() / channels as f64 * 64.0);
        add(format!("lin{i}.model.1.weight"), vec![1, channels, 1, 1], head.collect());
    }
    tensors
}

/// The same under flax's names, in flax's layout.
fn flax_weights(network: &Network) -> Vec<Written> {
    let mut tensors = torch_weights(network);
    for tensor in &mut tensors {
        tensor.name = tensor.name.replace("net.slice.", "Net_0/Conv_");
        tensor.name = tensor.name.replace(".weight", "/kernel").replace(".bias", "/bias");
        let [to, from, height, width] = tensor.shape[..] else { continue };
        let mut values = Vec::new();
        for at in 0..height * width {
            for i in 0..from {
                let area = height * width;
                values.extend((0..to).map(|o| tensor.values[(o * from + i) * area + at]));
            }
        }
        (tensor.shape, tensor.values) = (vec![height, width, from, to], values);
    }
    tensors
}

/// The tensors in a file of the plainest container.
fn file(tensors: &[Written]) -> Vec<u8> {
    let mut header = serde_json::Map::new();
    let mut data: Vec<u8> = Vec::new();
    for Written { name, shape, values } in tensors {
        let begin = data.len();
        data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        let entry = serde_json::json!({
            "dtype": "F32", "shape": shape, "data_offsets": [begin, data.len()]
        });
        header.insert(name.clone(), entry);
    }
    let header = serde_json::to_string(&header).unwrap();
    let length = (header.len() as u64).to_le_bytes();
    [&length, header.as_bytes(), &data].concat()
}

fn read(tensors: &[Written]) -> Result<Lpips, LpipsError> {
    Lpips::from_bytes(&file(tensors), Path::new(FILE))
}

#[track_caller]
fn expect(lpips: &Lpips, cases: [(Make, usize, usize, f64); 2]) {
    for (make, width, height, expected) in cases {
        let (a, b) = make(width, height);
        let found = lpips.distance(&a, &b, width, height).unwrap();
        println!("{}: {found:.9}, {:.1e} from lpips", lpips.network(), found - expected);
        assert!((found - expected).abs() < 1e-4 * expected, "{found} {expected}");
        assert_eq!(lpips.distance(&a, &a, width, height), Some(0.0));
    }
}

#[test]
fn as_the_package_says() {
    let [alex, vgg] = Network::ALL;
    let lpips = read(&flax_weights(alex)).unwrap();
    assert_eq!(lpips.network(), "AlexNet");
    expect(&lpips, [(patterns, 64, 64, 0.025_877_493), (soft, 75, 66, 0.285_852_760)]);
    let lpips = read(&torch_weights(vgg)).unwrap();
    assert_eq!(lpips.network(), "VGG16");
    expect(&lpips, [(patterns, 64, 64, 0.038_365_375), (soft, 75, 66, 0.395_270_318)]);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let lpips = read(&flax_weights(Network::ALL[0])).unwrap();
    let (a, b) = patterns(200, 150);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| lpips.distance(&a, &b, 200, 150).unwrap().to_bits())
    };
    let one = with(1);
    assert!([2, 3, 7].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn small_pictures_have_none() {
    let lpips = read(&flax_weights(Network::ALL[0])).unwrap();
    let grey = |side: usize| vec![128; side * side * 3];
    assert_eq!(lpips.distance(&grey(30), &grey(30), 30, 30), None);
    assert_eq!(lpips.distance(&grey(31), &grey(31), 31, 31), Some(0.0));
    assert_eq!(lpips.distance(&[], &[], 0, 7), None);
}

/// The state of the package holds its scaling, and every head twice.
#[test]
fn what_the_package_keeps_beside_the_weights() {
    let mut tensors = torch_weights(Network::ALL[0]);
    for (name, values) in [("shift", features::SHIFT), ("scale", features::SCALE)] {
        let name = format!("scaling_layer.{name}");
        tensors.push(Written { name, shape: vec![1, 3, 1, 1], values: values.to_vec() });
    }
    for (i, channels) in Network::ALL[0].taps().enumerate() {
        let values = tensors[10 + i].values.clone();
        let name = format!("lins.{i}.model.1.weight");
        tensors.push(Written { name, shape: vec![1, channels, 1, 1], values });
    }
    read(&tensors).unwrap();
    tensors[19].values[0] += 1.0;
    let error = read(&tensors).unwrap_err().to_string();
    assert!(error.contains("lins.2.model.1.weight is not the same as the head"), "{error}");
    tensors[15].values[0] = 0.5;
    let error = read(&tensors).unwrap_err().to_string();
    assert!(error.contains("scaling_layer.shift is neither the shift nor the scale"), "{error}");
}

#[test]
fn other_tensors_are_refused_in_one_line() {
    let refused = |change: &dyn Fn(&mut Vec<Written>)| {
        let mut tensors = flax_weights(Network::ALL[0]);
        change(&mut tensors);
        let error = read(&tensors).unwrap_err().to_string();
        assert!(error.starts_with(FILE) && !error.contains('\n'), "{error}");
        error[FILE.len() + 2..].split(';').next().unwrap().to_owned()
    };
    assert_eq!(
        refused(&|tensors| drop(tensors.remove(0))),
        "4 kernels of convolutions where 5 (AlexNet) or 13 (VGG16) were expected"
    );
    assert_eq!(
        refused(&|tensors| drop(tensors.remove(1))),
        "4 biases of convolutions where as many as kernels were expected"
    );
    assert_eq!(refused(&|tensors| drop(tensors.pop())), "4 heads where 5 were expected");
    assert_eq!(
        refused(&|tensors| tensors[0].shape = vec![11, 11, 64, 3]),
        "Net_0/Conv_0/kernel has the shape [11, 11, 64, 3] where [11, 11, 3, 64] or \
         [64, 3, 11, 11] was expected"
    );
    assert_eq!(
        refused(&|tensors| tensors[0].shape = vec![121, 192]),
        "Net_0/Conv_0/kernel has the shape [121, 192] where one of a kernel, a bias or a head was \
         expected"
    );
    assert_eq!(
        refused(&|tensors| {
            tensors[3].name = "Net_0/Conv_1/\nbias".to_owned();
            tensors[3].values[7] = f32::NAN;
        }),
        r"Net_0/Conv_1/\nbias holds numbers that are not finite"
    );
    assert_eq!(
        refused(&|tensors| tensors[2].values[0] = f32::INFINITY),
        "Net_0/Conv_1/kernel holds numbers that are not finite"
    );
    assert_eq!(
        Lpips::from_bytes(b"PK", Path::new(FILE)).unwrap_err().to_string(),
        "weights.npz: not a checkpoint that can be read: begins with 50 4b 00 00 00 00 00 00, \
         expected what torch.save, numpy.save, safetensors or instant-ngp write; LPIPS weights \
         are read from .npz, as numpy.savez writes"
    );
    let error = Lpips::read(Path::new("no/weights.npz")).unwrap_err().to_string();
    assert!(error.starts_with("no/weights.npz: cannot be read: "), "{error}");
}

/// The folder of trained weights, where `POCKETNERF_DATA` says that it lies.
fn trained() -> Option<PathBuf> {
    let data = std::env::var_os("POCKETNERF_DATA");
    if data.is_none() {
        let required = std::env::var_os("POCKETNERF_REQUIRE_DATA").is_some();
        assert!(!required, "POCKETNERF_DATA is not set, and POCKETNERF_REQUIRE_DATA is");
        println!("skipped: POCKETNERF_DATA is not set");
    }
    Some(PathBuf::from(data?).join("lpips"))
}

/// The pictures of the package lpips, and what its README says of them.
#[test]
fn trained_weights() {
    let Some(folder) = trained() else { return };
    let lpips = Lpips::read(&folder.join("lpips_alexnet.npz")).unwrap();
    assert_eq!(lpips.network(), "AlexNet");
    let picture = |name| image_file::open(folder.join(name)).unwrap().to_rgb8();
    let truth = picture("ex_ref.png");
    for (name, expected) in [("ex_p0.png", 0.7219), ("ex_p1.png", 0.1376)] {
        let size = truth.dimensions();
        let found = lpips.distance(&picture(name), &truth, size.0 as usize, size.1 as usize);
        let found = found.unwrap();
        println!("{name}: {found:.6}, expected {expected}");
        assert!((found - expected).abs() < 5e-4, "{found} {expected}");
    }
}

/// Says how long a pair of 800x800 pictures takes; a figure needs a release build.
#[test]
#[ignore = "a measurement"]
fn how_long_a_pair_takes() {
    let (a, b) = patterns(800, 800);
    for network in Network::ALL {
        let lpips = read(&torch_weights(network)).unwrap();
        for _ in 0..4 {
            let begun = Instant::now();
            let distance = lpips.distance(&a, &b, 800, 800).unwrap();
            let (seconds, threads) = (begun.elapsed().as_secs_f64(), rayon::current_num_threads());
            println!("{}: {distance:.6}, {seconds:.2} s, {threads} threads", network.name);
        }
    }
}
