//! What `torch.save` writes.

use pocketnerf_formats::import::{Checkpoint, Container, ElementType, ImportError};

use super::{expect, fixture, tensor};

/// The same checkpoint in every container of torch.
#[test]
fn every_container_holds_the_same() {
    let files = [
        ("zip.pt", Container::TorchZip),
        ("legacy.pt", Container::TorchLegacy),
        ("legacy_protocol_4.pt", Container::TorchLegacy),
    ];
    let mut names = Vec::new();
    for (file, container) in files {
        let bytes = fixture(file);
        let checkpoint = Checkpoint::read(&bytes).unwrap();
        assert_eq!(checkpoint.container(), container);
        scalars(&checkpoint);
        views(&checkpoint);
        types(&checkpoint);
        nested(&checkpoint);
        numpy(&checkpoint);
        names.push(checkpoint.names().map(str::to_owned).collect::<Vec<_>>());
    }
    assert_eq!(names[0].len(), 34);
    assert_eq!(names[0][..2], ["model.weight", "model.bias"]);
    assert!(names.iter().all(|same| *same == names[0]));
}

fn scalars(checkpoint: &Checkpoint<'_>) {
    let numbers = [
        ("global_step", 200_000.0),
        ("lr", 5e-4),
        ("big", 2_f64.powi(70)),
        ("negative", -3.0),
        ("white", 1.0),
        ("optimizer.param_groups.0.betas.1", 0.999),
        ("numpy.number", 0.1),
    ];
    for (name, number) in numbers {
        assert_eq!(checkpoint.number(name), Some(number), "{name}");
    }
    assert_eq!(checkpoint.text("name"), Some("tiny é"));
    assert_eq!((checkpoint.text("lr"), checkpoint.number("name")), (None, None));
    assert!(checkpoint.number("nothing").is_none() && checkpoint.tensor("lr").is_none());
    assert!(checkpoint.tensor("numpy.texts").is_none());
}

fn views(checkpoint: &Checkpoint<'_>) {
    let counted: Vec<i32> = (0..24).collect();
    expect(checkpoint, "views.base", &[20], &counted[..20]);
    expect(checkpoint, "views.slice", &[2, 5], &counted[5..15]);
    let transposed = [0, 4, 8, 1, 5, 9, 2, 6, 10, 3, 7, 11];
    expect(checkpoint, "views.transposed", &[4, 3], &transposed);
    expect(checkpoint, "views.strided", &[2, 2], &[6, 9, 18, 21]);
    expect(checkpoint, "views.expanded", &[2, 3], &[28; 6]);
    expect(checkpoint, "views.channels", &[1, 2, 3, 4], &counted);
}

fn types(checkpoint: &Checkpoint<'_>) {
    use ElementType::{Bf16, Bool, F16, F64, I8, I16, I32, I64, U8, U16};
    let eighths = [0, 1, 2, 3, 4];
    for (name, element) in [("f16", F16), ("bf16", Bf16), ("f64", F64)] {
        let name = format!("types.{name}");
        expect(checkpoint, &name, &[5], &eighths);
        assert_eq!(tensor(checkpoint, &name).element_type(), element);
    }
    for (name, element) in [("i64", I64), ("i32", I32), ("i16", I16), ("i8", I8)] {
        let name = format!("types.{name}");
        expect(checkpoint, &name, &[5], &eighths.map(|n| 8 * (n - 2)));
        assert_eq!(tensor(checkpoint, &name).element_type(), element);
    }
    let bytes = tensor(checkpoint, "types.u8");
    assert_eq!((bytes.element_type(), bytes.to_bytes().unwrap()), (U8, (200..205).collect()));
    let truths = tensor(checkpoint, "types.bool");
    assert_eq!((truths.element_type(), truths.to_bytes().unwrap()), (Bool, vec![0, 1, 0, 1, 0]));
    assert_eq!(truths.to_f32().unwrap(), [0.0, 1.0, 0.0, 1.0, 0.0]);
    let wide = tensor(checkpoint, "types.u16");
    assert_eq!(wide.to_f32().unwrap(), [65_000.0, 65_001.0, 65_002.0, 65_003.0, 65_004.0]);
    assert_eq!(wide.to_bytes(), Err(ImportError::NotBytes(U16)));
}

fn nested(checkpoint: &Checkpoint<'_>) {
    expect(checkpoint, "model.weight", &[2, 3], &[0, 1, 2, 3, 4, 5]);
    expect(checkpoint, "model.bias", &[2], &[-8, -7]);
    expect(checkpoint, "parameter", &[4], &[0, 1, 2, 3]);
    expect(checkpoint, "list.0", &[2], &[0, 1]);
    expect(checkpoint, "list.1.0", &[3], &[0, 1, 2]);
    expect(checkpoint, "list.2.0", &[1], &[0]);
    expect(checkpoint, "number", &[], &[2]);
    expect(checkpoint, "empty", &[0, 3], &[]);
    expect(checkpoint, "optimizer.state.0.step", &[], &[8]);
    assert_eq!(tensor(checkpoint, "optimizer.state.0.exp_avg").shape(), [2, 3]);
    let gradient = tensor(checkpoint, "optimizer.state.1.exp_avg").to_f32().unwrap();
    assert!(gradient.iter().all(|mean| (mean - 0.1).abs() < 1e-6), "{gradient:?}");
}

fn numpy(checkpoint: &Checkpoint<'_>) {
    expect(checkpoint, "numpy.array", &[2, 3], &[0, 1, 2, 3, 4, 5]);
    expect(checkpoint, "numpy.fortran", &[2, 3], &[0, 1, 2, 3, 4, 5]);
    expect(checkpoint, "numpy.empty", &[0, 2], &[]);
    let bytes = tensor(checkpoint, "numpy.bytes").to_bytes().unwrap();
    assert_eq!(bytes, [250, 251, 252, 253, 254, 255]);
}

/// Hyperparameters of every kind stand beside the weights without hindering them.
#[test]
fn lightning() {
    let bytes = fixture("lightning.ckpt");
    let checkpoint = Checkpoint::read(&bytes).unwrap();
    let weight = "state_dict.nerf_coarse.xyz_encoding_1.0.weight";
    assert!(checkpoint.names().eq([weight]));
    expect(&checkpoint, weight, &[2, 3], &[0, 1, 2, 3, 4, 5]);
    let hyper = |name: &str| format!("hyper_parameters.{name}");
    assert_eq!(checkpoint.number("epoch"), Some(3.0));
    assert_eq!(checkpoint.text("pytorch-lightning_version"), Some("1.9.0"));
    assert_eq!(checkpoint.number(&hyper("hparams.N_samples")), Some(64.0));
    assert_eq!(checkpoint.text(&hyper("hparams.dataset_name")), Some("blender"));
    assert_eq!(checkpoint.number(&hyper("hparams.img_wh.1")), Some(800.0));
    assert_eq!(checkpoint.number(&hyper("size.1")), Some(3.0));
    assert_eq!(checkpoint.number(&hyper("defaults.a.0")), Some(1.0));
    assert_eq!(checkpoint.text(&hyper("5")), Some("five"));
    assert_eq!(checkpoint.number("lr_schedulers.0.milestones.2"), Some(2.0));
}

#[test]
fn a_tensor_alone_has_the_empty_name() {
    let bytes = fixture("tensor.pt");
    let checkpoint = Checkpoint::read(&bytes).unwrap();
    assert!(checkpoint.names().eq([""]));
    expect(&checkpoint, "", &[2, 3], &[0, 1, 2, 3, 4, 5]);
}

#[test]
fn both_orders_of_bytes() {
    for file in ["little_endian.pt", "big_endian.pt"] {
        let bytes = fixture(file);
        let checkpoint = Checkpoint::read(&bytes).unwrap();
        expect(&checkpoint, "a", &[2, 3], &[0, 1, 2, 3, 4, 5]);
        expect(&checkpoint, "b", &[2], &[0, 1]);
    }
}

#[test]
fn compressed_entries_are_refused() {
    let error = Checkpoint::read(&fixture("compressed.pt")).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the entry little_endian/data.pkl is compressed or encrypted, where torch.save stores: \
         refused"
    );
}

/// Any number of entries could share their bytes, each of them taking time.
#[test]
fn entries_that_overlap_are_refused() {
    let mut bytes = fixture("tensor.pt");
    let record = bytes.windows(4).position(|window| window == b"PK\x01\x02").unwrap();
    let to_the_end = u32::try_from(bytes.len() - 64).unwrap().to_le_bytes();
    bytes[record + 16..record + 28].copy_from_slice(&[[0; 4], to_the_end, to_the_end].concat());
    let error = Checkpoint::read(&bytes).unwrap_err();
    assert_eq!(error.to_string(), "the zip archive cannot be read: its entries overlap");
}

#[test]
fn damaged_weights_of_an_archive_are_refused() {
    let mut bytes = fixture("tensor.pt");
    let one_eighth = 0.125_f32.to_le_bytes();
    let at = bytes.windows(4).position(|window| window == one_eighth).unwrap();
    bytes[at] ^= 1;
    let error = Checkpoint::read(&bytes).unwrap_err();
    assert!(matches!(&error, ImportError::Checksum { entry, .. } if entry == "tensor/data/0"));
}
