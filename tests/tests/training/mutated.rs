//! Damaged and forged checkpoints: whatever the bytes, reading and going on
//! end without a panic.

use std::path::Path;
use std::time::Instant;

use arbtest::arbitrary::{self, Unstructured};
use arbtest::arbtest;
use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{Container, SectionId};
use pocketnerf_tests::checksums::repair;
use pocketnerf_train::trainer::Checkpoint;
use pocketnerf_train::trainer::checkpoint::kind;

use super::setup::{dataset, saved_after};

fn read(bytes: &[u8]) -> Option<Checkpoint> {
    Checkpoint::from_bytes(Path::new("forged"), bytes).ok()
}

/// Where the payload of a section lies.
fn range(bytes: &[u8], kind: u32) -> std::ops::Range<usize> {
    let section = Container::open(bytes).unwrap().find(SectionId::first(kind)).unwrap();
    section.offset as usize..section.offset as usize + section.bytes.len()
}

fn mutate(u: &mut Unstructured<'_>, bytes: &mut Vec<u8>) -> arbitrary::Result<()> {
    // Half of the damage goes to header, table and metadata.
    let end = if u.ratio(1, 2)? { bytes.len().min(3000) } else { bytes.len() };
    let at = u.choose_index(end)?;
    match u.int_in_range(0..=2)? {
        0 => bytes[at] ^= 1 << u.int_in_range(0..=7)?,
        1 => bytes[at] = u.arbitrary()?,
        _ => bytes.truncate(at.max(1)),
    }
    Ok(())
}

#[test]
fn damaged_checkpoints_are_refused() {
    let saved = saved_after(20);
    arbtest(|u| {
        let mut bytes = saved.clone();
        mutate(u, &mut bytes)?;
        assert!(bytes == saved || read(&bytes).is_none());
        Ok(())
    })
    .budget_ms(1500);
}

#[test]
fn forged_checkpoints_never_panic() {
    let saved = saved_after(20);
    let mut accepted = 0;
    arbtest(|u| {
        let mut bytes = saved.clone();
        for _ in 0..u.int_in_range(1..=3)? {
            mutate(u, &mut bytes)?;
        }
        repair(&mut bytes);
        accepted += usize::from(read(&bytes).is_some());
        Ok(())
    })
    .budget_ms(2000);
    assert!(accepted > 0);
}

/// Every byte of the trainer's state, with checksums made right: what is not
/// refused can go on.
#[test]
fn forged_states_are_refused_or_go_on() {
    let saved = saved_after(20);
    let dataset = dataset();
    let (mut refused, mut gone_on) = (0, 0);
    for at in range(&saved, kind::TRAINER) {
        for value in [0, 0x7f, 0xff, saved[at] ^ 1] {
            let mut bytes = saved.clone();
            bytes[at] = value;
            repair(&mut bytes);
            let resumed = read(&bytes)
                .and_then(|c| c.resume(dataset.clone(), SimdLevel::detect(), Instant::now()).ok());
            let Some((mut trainer, mut run)) = resumed else {
                refused += 1;
                continue;
            };
            // A forged run may end at once or be given up; it may not panic.
            let _ = run.step(&mut trainer);
            gone_on += 1;
        }
    }
    assert!(refused > 50 && gone_on > 50, "{refused} {gone_on}");
}

#[test]
fn every_truncation_is_refused() {
    let saved = saved_after(1);
    for end in (0..saved.len()).step_by(97).chain(saved.len() - 70..saved.len()) {
        assert!(read(&saved[..end]).is_none(), "{end}");
    }
}
