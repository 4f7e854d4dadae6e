//! Unpacks, opens and verifies whatever it is given. Checksums are made right first, or
//! nearly every input would end there.
//!
//! `cargo +nightly fuzz run open corpus golden` in `tests/`, `golden` being the
//! folder of golden files that the search starts from.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../src/checksums.rs"]
mod checksums;

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = bytes.to_vec();
    checksums::repair(&mut bytes);
    // Small files stand for few bytes, if they stand for any.
    if let Ok(length @ ..0x100_0000) = pocketnerf_formats::unpacked_len(&bytes) {
        let mut unpacked = vec![0; length as usize];
        if pocketnerf_formats::unpack_into(&bytes, &mut unpacked).is_ok() {
            bytes = unpacked;
        }
    }
    if let Ok(file) = pocketnerf_formats::open(&bytes) {
        let _ = file.verify();
        for (_, view) in file.tensors() {
            assert_eq!(view.bytes().len(), view.rows() * view.cols() * view.dtype().size());
        }
        file.model.validate().expect("what opens is a model");
    }
});
