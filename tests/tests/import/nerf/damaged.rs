//! Checkpoints that are not what they seem: refused in one line, never a panic.

use std::time::{Duration, Instant};

use pocketnerf_core::encoding::Affine;
use pocketnerf_formats::import::Checkpoint;
use pocketnerf_formats::import::FieldError;
use pocketnerf_formats::import::nerf::Nerf;
use pocketnerf_train::random::Random;

use super::{bytes, nerf};

/// Mutations of every file.
const MUTATIONS: u64 = 10_000;

/// A safetensors file of matrices and vectors of zeros, or of `value`.
fn file(tensors: &[(&str, &[usize])], value: f32) -> Vec<u8> {
    let (mut entries, mut data) = (Vec::new(), Vec::new());
    for (name, shape) in tensors {
        let begin = data.len();
        (0..shape.iter().product()).for_each(|_| data.extend(value.to_le_bytes()));
        entries.push(format!(
            r#""{name}":{{"dtype":"F32","shape":{shape:?},"data_offsets":[{begin},{}]}}"#,
            data.len()
        ));
    }
    let header = format!("{{{}}}", entries.join(","));
    let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
    bytes.extend(header.bytes());
    bytes.extend(data);
    bytes
}

/// A network as small as can be: 27 and 15 values, two layers of 4.
const SMALL: [(&str, &[usize]); 12] = [
    ("pts_linears.0.weight", &[4, 27]),
    ("pts_linears.0.bias", &[4]),
    ("pts_linears.1.weight", &[4, 4]),
    ("pts_linears.1.bias", &[4]),
    ("feature_linear.weight", &[4, 4]),
    ("feature_linear.bias", &[4]),
    ("alpha_linear.weight", &[1, 4]),
    ("alpha_linear.bias", &[1]),
    ("views_linears.0.weight", &[2, 19]),
    ("views_linears.0.bias", &[2]),
    ("rgb_linear.weight", &[3, 2]),
    ("rgb_linear.bias", &[3]),
];

#[track_caller]
fn refused(tensors: &[(&str, &[usize])], value: f32) -> FieldError {
    let error = nerf(&file(tensors, value)).unwrap_err();
    assert!(!error.to_string().contains('\n'));
    error
}

#[test]
fn each_defect_is_named() {
    let small = nerf(&file(&SMALL, 0.5)).unwrap();
    assert!(small.field(Affine::IDENTITY).is_ok());
    for (i, (name, _)) in SMALL.iter().enumerate() {
        let mut rest = SMALL.to_vec();
        rest.remove(i);
        let error = refused(&rest, 0.5);
        // Nothing tells another program's network from one without its first weight.
        if i == 0 {
            assert!(matches!(error, FieldError::Unknown { .. }), "{error}");
        } else {
            assert_eq!(error, FieldError::Missing((*name).to_owned()));
        }
    }
    for (at, shape) in
        [(1, &[5][..]), (2, &[4, 5]), (4, &[4, 5]), (6, &[1, 5]), (8, &[2, 3]), (10, &[3, 3])]
    {
        let mut wrong = SMALL;
        wrong[at].1 = shape;
        assert!(matches!(refused(&wrong, 0.5), FieldError::Shape { .. }), "{:?}", wrong[at]);
    }
    let mut vector = SMALL;
    vector[0].1 = &[108];
    assert!(matches!(refused(&vector, 0.5), FieldError::Shape { .. }));
    let mut odd = SMALL;
    odd[0].1 = &[4, 28];
    assert!(matches!(refused(&odd, 0.5), FieldError::Encoding { what: "position", found: 28 }));
    odd = SMALL;
    odd[8].1 = &[2, 21];
    assert!(matches!(refused(&odd, 0.5), FieldError::Encoding { what: "direction", found: 17 }));
    let mut more = SMALL.to_vec();
    more.push(("transient_encoding.weight", &[2, 2]));
    assert_eq!(refused(&more, 0.5), FieldError::Extra("transient_encoding.weight".to_owned()));
    for value in [f32::NAN, f32::INFINITY] {
        assert!(matches!(refused(&SMALL, value), FieldError::NotFinite(_)));
    }
    let other = refused(&[("encoder.embeddings", &[4, 2]), ("sigma_net.0.weight", &[2, 2])], 0.5);
    assert!(other.to_string().contains("encoder.embeddings sigma_net.0.weight"), "{other}");
}

#[test]
fn more_layers_than_there_may_be() {
    let names: Vec<[String; 2]> =
        (0..11).map(|i| ["weight", "bias"].map(|p| format!("pts_linears.{i}.{p}"))).collect();
    let mut deep = SMALL[4..].to_vec();
    for (i, [weight, bias]) in names.iter().enumerate() {
        deep.push((weight, if i == 0 { &[4, 27] } else { &[4, 4] }));
        deep.push((bias, &[4]));
    }
    assert_eq!(refused(&deep, 0.5), FieldError::Layers(11));
}

#[test]
fn ten_thousand_mutations() {
    for name in ["flexible.ckpt", "yenchenlin.tar", "model_000007.npy", "nerf_pl.ckpt"] {
        let whole = bytes(name);
        let [mut read, mut networks] = [0; 2];
        for i in 0..MUTATIONS {
            let mut random = Random::new(i, [name.len() as u64, 0, 0]);
            let mut bytes = whole.clone();
            for _ in 0..1 + random.below(4) {
                let at = random.below(bytes.len());
                bytes[at] = random.below(256) as u8;
            }
            let begun = Instant::now();
            if let Ok(checkpoint) = Checkpoint::read(&bytes) {
                read += 1;
                match Nerf::read(&checkpoint) {
                    Ok(nerf) => {
                        networks += 1;
                        // Whatever it says: a field that core has checked.
                        let _ = nerf.field(Affine::IDENTITY);
                    }
                    Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
                }
            }
            assert!(begun.elapsed() < Duration::from_secs(5), "{name}, mutation {i}");
        }
        // Numbers may change unnoticed where there are no checksums.
        println!("{name}: {read} read, {networks} networks");
    }
}
