//! What cannot be resumed is refused in one line: the file, what was found,
//! what was expected, what to do.

use std::path::Path;
use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{
    Container, ContainerWriter, Precision, Role, SectionId, TensorName, kind as model_kind, open,
};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::trainer::Checkpoint;
use pocketnerf_train::trainer::checkpoint::{Problem, kind};

use super::setup::{dataset, read, saved_after};

/// The line for these bytes, without the file's name.
fn line(bytes: &[u8]) -> String {
    let error = Checkpoint::from_bytes(Path::new("a.ckpt.pnerf"), bytes).unwrap_err();
    after_the_name(&error.to_string())
}

fn after_the_name(line: &str) -> String {
    assert!(!line.contains('\n'), "{line}");
    line.strip_prefix("a.ckpt.pnerf: ").unwrap().to_owned()
}

/// The line for a checkpoint that can be read, on the right dataset.
fn line_on_dataset(bytes: &[u8], simd: SimdLevel) -> String {
    let checkpoint = Checkpoint::from_bytes(Path::new("a.ckpt.pnerf"), bytes).unwrap();
    let error = checkpoint.resume(dataset(), simd, Instant::now()).unwrap_err();
    after_the_name(&error.to_string())
}

/// A file with one of its sections changed.
fn with(bytes: &[u8], changed: u32, change: impl Fn(&mut u16, &mut Vec<u8>)) -> Vec<u8> {
    let mut writer = ContainerWriter::new();
    for section in Container::open(bytes).unwrap().sections() {
        let (mut version, mut payload) = (section.version, section.bytes.to_vec());
        if section.id == SectionId::first(changed) {
            change(&mut version, &mut payload);
        }
        writer.add(section.id, version, section.is_critical(), payload);
    }
    writer.finish().unwrap()
}

/// With sections that it lacks.
fn beside(bytes: &[u8], added: &[(SectionId, &[u8])]) -> Vec<u8> {
    let mut writer = ContainerWriter::new();
    for section in Container::open(bytes).unwrap().sections() {
        writer.add(section.id, section.version, section.is_critical(), section.bytes);
    }
    for (id, bytes) in added {
        writer.add(*id, 1, false, *bytes);
    }
    writer.finish().unwrap()
}

const ANOTHER: &str = "resume from another checkpoint or train from scratch without --resume";

#[test]
fn files_that_are_no_checkpoints() {
    let missing = Checkpoint::read(Path::new("none/a.ckpt.pnerf")).unwrap_err().to_string();
    assert!(missing.starts_with("none/a.ckpt.pnerf: cannot be read: "), "{missing}");
    assert!(missing.ends_with("; check the path and its permissions"), "{missing}");
    assert_eq!(
        line(b"\x89PNG\r\n\x1a\n and more of a picture, more than a header"),
        "not a .pnerf file: begins with 89 50 4e 47 0d 0a 1a 0a, expected \
         ab 50 4e 52 46 0d 0a 1a; expected a checkpoint; \
         resume from another one or train from scratch without --resume"
    );
    assert!(line(b"").starts_with("not a .pnerf file"));
    let saved = saved_after(1);
    assert!(line(&saved[..saved.len() - 1]).starts_with("the file is cut short: "));
    let mut damaged = saved.clone();
    *damaged.last_mut().unwrap() ^= 1;
    let text = line(&damaged);
    assert!(text.contains("was expected: the file is damaged; expected a checkpoint"), "{text}");
    let file = open(&saved).unwrap();
    let model = pocketnerf_formats::write(&file.model, &file.about, Precision::F16).unwrap();
    assert_eq!(
        line(&model),
        "this is a model, expected a checkpoint; give the file that ends in .ckpt.pnerf, \
         or train from scratch without --resume"
    );
}

#[test]
fn sections_that_cannot_be_used() {
    let saved = saved_after(1);
    assert_eq!(
        line(&with(&saved, kind::TRAINER, |version, _| *version = 2)),
        "section of kind 0x1000: version 2 where 1 was expected; \
         resume with the version of this program that wrote it"
    );
    let changes: [fn(&mut Vec<u8>); 3] = [|b| b.push(0), |b| b.truncate(9), Vec::clear];
    for change in changes {
        assert_eq!(
            line(&with(&saved, kind::TRAINER, |_, bytes| change(bytes))),
            format!(
                "the trainer's state cannot be used: section TRAINER is unreadable or \
                 outside its range; {ANOTHER}"
            )
        );
    }
    // Grids have no first moment.
    let (all, networks) = (count(&saved, |_| true), count(&saved, |name| !is_grid(name)));
    for (kind, number, n) in
        [(kind::MEAN, "0x1001", 4 * networks), (kind::SQUARE, "0x1002", 4 * all)]
    {
        assert_eq!(
            line(&with(&saved, kind, |_, bytes| bytes.truncate(8))),
            format!(
                "section of kind {number}: 8 bytes where {n} were expected: \
                 the file is damaged; {ANOTHER}"
            )
        );
    }
    let negative = |bytes: &mut Vec<u8>| bytes[..4].copy_from_slice(&(-1f32).to_le_bytes());
    assert!(
        line(&with(&saved, kind::DENSITY, |_, bytes| negative(bytes)))
            .starts_with("the trainer's state cannot be used: section DENSITY is ")
    );
    assert!(
        line(&with(&saved, kind::SCALES, |_, bytes| bytes[0] = 0x80))
            .starts_with("the trainer's state cannot be used: section SCALES is ")
    );
    // A teacher that is no model, and more than there can be.
    let teacher = |index| SectionId { kind: kind::TEACHER, index };
    for (n, bytes) in [(1, &b"no model"[..]), (9, &saved)] {
        let teachers: Vec<_> = (0..n).map(|index| (teacher(index), bytes)).collect();
        assert!(
            line(&beside(&saved, &teachers))
                .starts_with("the trainer's state cannot be used: section TEACHER is ")
        );
    }
    for bytes in [&[0; 12][..], &[0xff; 12], &[0; 4]] {
        assert!(
            line(&beside(&saved, &[(SectionId::first(kind::CLEARING), bytes)]))
                .starts_with("the trainer's state cannot be used: section CLEARING is ")
        );
    }
    let levels = count_levels(&saved);
    assert!(line(&with(&saved, kind::SCALES, |_, bytes| bytes.push(0))).starts_with(&format!(
        "section of kind 0x1005: {} bytes where {levels} were expected",
        levels + 1
    )));
}

fn is_grid(name: TensorName) -> bool {
    name.role() == Role::Table
}

fn count_levels(saved: &[u8]) -> usize {
    open(saved).unwrap().tensors().filter(|(name, _)| is_grid(*name)).count()
}

fn count(saved: &[u8], wanted: impl Fn(TensorName) -> bool) -> usize {
    let file = open(saved).unwrap();
    let tensors = file.tensors().filter(|(name, _)| wanted(*name));
    tensors.map(|(_, view)| view.rows() * view.cols()).sum()
}

#[test]
fn models_that_no_training_makes() {
    let saved = saved_after(1);
    let file = open(&saved).unwrap();
    let f16 = pocketnerf_formats::write(&file.model, &file.about, Precision::F16).unwrap();
    let mut writer = ContainerWriter::new();
    for section in Container::open(&f16).unwrap().sections() {
        writer.add(section.id, section.version, true, section.bytes);
    }
    for section in file.sections().filter(|s| s.id.kind >= model_kind::PROGRAM) {
        writer.add(section.id, section.version, false, section.bytes);
    }
    assert_eq!(
        line(&writer.finish().unwrap()),
        "the model in it is not one that training makes (weights in f16), expected a hash grid \
         or another field in f32; train from scratch without --resume"
    );
}

#[test]
fn other_data_and_other_programs() {
    let saved = saved_after(1);
    let mut other = dataset();
    other.source = "data/other".into();
    other.views[3].rgba[0] ^= 1;
    let (expected, found) = (dataset().fingerprint(), other.fingerprint());
    let error = read(&saved).resume(other, SimdLevel::detect(), Instant::now()).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "run.ckpt.pnerf: trained on \"tiny\" (fingerprint {expected:016x}), but \
             \"data/other\" has fingerprint {found:016x}; \
             give the dataset that the run began with, unchanged"
        )
    );
    let smaller = builtin::dataset(Split::Train, 40);
    let error = read(&saved).resume(smaller, SimdLevel::detect(), Instant::now()).unwrap_err();
    assert!(matches!(error.problem, Problem::Dataset { .. }));

    let fewer = with(&saved, kind::DENSITY, |_, bytes| bytes.truncate(bytes.len() - 4));
    assert_eq!(
        line_on_dataset(&fewer, SimdLevel::detect()),
        "this build does not find the same cells that may be occupied in the dataset; \
         resume with the version of this program that wrote the checkpoint"
    );
    let changes: [fn(&mut Vec<u8>); 3] = [
        |bytes| bytes.truncate(bytes.len() - 8),
        Vec::clear,
        |bytes| bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes()),
    ];
    for change in changes {
        let other = with(&saved, kind::PIXEL_ERRORS, |_, bytes| change(bytes));
        assert_eq!(
            line_on_dataset(&other, SimdLevel::detect()),
            "this build does not find the same tiles of the images in the dataset; \
             resume with the version of this program that wrote the checkpoint"
        );
    }
    let elsewhere = if cfg!(target_arch = "x86_64") { SimdLevel::Neon } else { SimdLevel::Avx2 };
    let text = line_on_dataset(&saved, elsewhere);
    assert!(text.ends_with("; train from scratch without --resume"), "{text}");
}
