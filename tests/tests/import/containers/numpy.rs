//! What `numpy.save` writes.

use pocketnerf_formats::import::{Checkpoint, Container, ElementType};

use super::{expect, fixture, tensor};

/// The weights of the original NeRF: a list of arrays, pickled by three versions.
#[test]
fn lists_of_arrays() {
    for file in
        ["numpy/weights.npy", "numpy/weights_protocol_2.npy", "numpy/weights_protocol_5.npy"]
    {
        let bytes = fixture(file);
        let checkpoint = Checkpoint::read(&bytes).unwrap();
        assert_eq!(checkpoint.container(), Container::Numpy);
        assert!(checkpoint.names().eq(["0", "1", "2", "3", "4", "5"]));
        expect(&checkpoint, "0", &[2, 3], &[0, 1, 2, 3, 4, 5]);
        expect(&checkpoint, "1", &[2, 3], &[0, 1, 2, 3, 4, 5]);
        expect(&checkpoint, "2", &[3], &[0, 1, 2]);
        expect(&checkpoint, "3", &[3], &[0, 1, 2]);
        expect(&checkpoint, "4", &[3], &[0, 1, 2]);
        expect(&checkpoint, "5", &[3], &[-8, 0, 8]);
        let elements: Vec<_> =
            checkpoint.names().map(|name| tensor(&checkpoint, name).element_type()).collect();
        let f32 = ElementType::F32;
        let expected = [f32, f32, f32, ElementType::F64, ElementType::F16, ElementType::I32];
        assert_eq!(elements, expected);
    }
}

#[test]
fn arrays_of_numbers() {
    let bytes = fixture("numpy/fortran.npy");
    expect(&Checkpoint::read(&bytes).unwrap(), "", &[2, 3], &[0, 1, 2, 3, 4, 5]);
    let bytes = fixture("numpy/big_endian.npy");
    expect(&Checkpoint::read(&bytes).unwrap(), "", &[6], &[0, 1, 2, 3, 4, 5]);
}

/// `.npy` of version 1 around anything.
pub(crate) fn npy(header: &str, contents: &[u8]) -> Vec<u8> {
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), contents].concat()
}

#[test]
fn headers_are_refused_with_what_is_wrong() {
    let error = |header: &str| Checkpoint::read(&npy(header, &[0; 8])).unwrap_err().to_string();
    let of_type = |descr: &str| {
        error(&format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (1,), }}"))
    };
    assert_eq!(of_type("'<c8'"), "values of type <c8 are not read");
    assert!(of_type("[('a', '<f4')]").starts_with("the header of .npy: values of type [("));
    assert_eq!(
        of_type("'<f4'"),
        "4 bytes after the end of the checkpoint, where none were expected"
    );
    let of_shape = |shape: &str| {
        error(&format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}}}"))
    };
    assert_eq!(of_shape("(3,)"), "the tensor: it reaches beyond the end of its storage");
    assert_eq!(of_shape("(-1,)"), "the header of .npy: shape (-1,)}");
    let most = usize::MAX;
    let uncountable = "the tensor: its shape has more numbers than can be counted";
    assert_eq!(of_shape(&format!("({most}, {most})")), uncountable);
    assert_eq!(error("{'shape': (1,)}"), "the header of .npy: descr is missing");
}
