//! Damaged files: whatever the bytes, opening ends without a panic, and a model
//! that opens can be used.

use arbtest::arbitrary::{self, Unstructured};
use arbtest::arbtest;
use pocketnerf_formats::{About, Precision, open, write};
use pocketnerf_tests::checksums::repair;
use pocketnerf_tests::tiny::{self, Tiny};

/// Bytes of header, table and metadata of the goldens, at most.
const FRONT: usize = 2176;

/// Opens, verifies and walks through everything that a file offers.
fn use_everything(bytes: &[u8]) -> bool {
    let Ok(file) = open(bytes) else { return false };
    let range = bytes.as_ptr_range();
    for section in file.sections() {
        assert!(section.bytes.is_empty() || range.contains(&section.bytes.as_ptr()));
    }
    for (_, view) in file.tensors() {
        let n = view.rows() * view.cols();
        assert_eq!(view.bytes().len(), n * view.dtype().size());
        assert!(view.bytes().is_empty() || range.contains(&view.bytes().as_ptr()));
        let _ = (view.get(0), view.get(n.wrapping_sub(1)), view.get(n));
    }
    file.model.validate().unwrap();
    if let Some(occupancy) = file.model.occupancy {
        assert!((0.0..=1.0).contains(&occupancy.fraction()));
    }
    if file.verify().is_ok() {
        // A sound file can be written again, whatever it says.
        write(&file.model, &file.about, Precision::F32).unwrap();
    }
    true
}

fn goldens() -> [Vec<u8>; 7] {
    let tiny = Tiny::new();
    // One with sections DETAIL and PHOTOGRAPHS.
    let photographs = tiny::photographs();
    let about = About { photographs: Some(photographs.view()), ..tiny::about() };
    let mut detailed = tiny.hash_grid();
    detailed.display.tolerance = 0.0625;
    [
        write(&tiny.hash_grid(), &tiny::about(), Precision::F16).unwrap(),
        write(&tiny.per_sample(), &tiny::about(), Precision::F32).unwrap(),
        write(&detailed, &about, Precision::I8).unwrap(),
        write(&tiny.nerf(), &tiny::about(), Precision::F16).unwrap(),
        write(&tiny.plenoxels(), &tiny::about(), Precision::I8).unwrap(),
        write(&tiny.planes(), &tiny::about(), Precision::I8).unwrap(),
        write(&tiny.derf(), &tiny::about(), Precision::F16).unwrap(),
    ]
}

/// Changes a file in one of the ways that files are damaged.
fn mutate(u: &mut Unstructured<'_>, bytes: &mut Vec<u8>) -> arbitrary::Result<()> {
    if bytes.is_empty() {
        return Ok(());
    }
    // Half of the damage goes to header, table and metadata.
    let end = if u.ratio(1, 2)? { bytes.len().min(FRONT) } else { bytes.len() };
    let at = u.choose_index(end)?;
    match u.int_in_range(0..=3)? {
        0 => bytes[at] ^= 1 << u.int_in_range(0..=7)?,
        1 => bytes[at] = u.arbitrary()?,
        2 => bytes.truncate(at),
        _ => {
            let from = u.choose_index(bytes.len())?;
            let n = u.int_in_range(1..=64)?;
            let piece: Vec<u8> = bytes[from..].iter().take(n).copied().collect();
            let stop = (at + piece.len()).min(bytes.len());
            if u.arbitrary()? {
                bytes.splice(at..stop, piece);
            } else {
                bytes.splice(at..at, piece);
            }
        }
    }
    Ok(())
}

#[test]
fn damaged_files_never_verify() {
    let goldens = goldens();
    arbtest(|u| {
        let golden = &goldens[u.choose_index(goldens.len())?];
        let mut bytes = golden.clone();
        mutate(u, &mut bytes)?;
        if bytes != *golden {
            use_everything(&bytes);
            assert!(pocketnerf_formats::open_verified(&bytes).is_err());
        }
        Ok(())
    })
    .budget_ms(2000);
}

#[test]
fn forged_files_never_panic() {
    let goldens = goldens();
    arbtest(|u| {
        let mut bytes = goldens[u.choose_index(goldens.len())?].clone();
        for _ in 0..u.int_in_range(1..=4)? {
            mutate(u, &mut bytes)?;
        }
        repair(&mut bytes);
        use_everything(&bytes);
        Ok(())
    })
    .budget_ms(3000);
}

#[test]
fn every_truncation_is_refused() {
    for golden in goldens() {
        for end in 0..golden.len() {
            assert!(open(&golden[..end]).is_err(), "{end}");
        }
    }
}

#[test]
fn every_forged_byte_is_survived() {
    // Every byte of header, table and metadata, with checksums made right.
    let mut opened = 0;
    for golden in goldens() {
        for at in 0..golden.len().min(FRONT) {
            for value in [0, 1, 0x7f, 0x80, 0xff, golden[at].wrapping_add(1)] {
                let mut bytes = golden.clone();
                bytes[at] = value;
                repair(&mut bytes);
                opened += u32::from(use_everything(&bytes));
            }
        }
    }
    assert!(opened > 1000, "the checksums are not right: only {opened} files opened");
}
