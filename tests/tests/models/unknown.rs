//! Sections that no build knows.

use pocketnerf_core::Model;
use pocketnerf_formats::{ContainerWriter, FormatError, Precision, SectionId, open, open_verified};
use pocketnerf_tests::tiny::{self, Tiny};

use crate::compare::{F16_ROUNDING, assert_same_weights};
use crate::golden::golden;

/// A section kind that no build knows.
const UNKNOWN: SectionId = SectionId { kind: 0x7f, index: 1 };

fn with_unknown_section(model: &Model<'_>, critical: bool) -> Vec<u8> {
    let mut writer = ContainerWriter::new();
    writer.add_model(model, &tiny::about(), Precision::F16).unwrap();
    writer.add(UNKNOWN, 9, critical, &b"from a time to come"[..]);
    writer.finish().unwrap()
}

#[test]
fn unknown_ancillary_section_is_skipped() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let bytes = golden("unknown-ancillary.pnerf", &with_unknown_section(&model, false));
    let file = open_verified(&bytes).unwrap();
    assert_same_weights(&file.model, &model, F16_ROUNDING);
    let section = file.container().find(UNKNOWN).unwrap();
    assert_eq!((section.version, section.bytes), (9, &b"from a time to come"[..]));
}

#[test]
fn unknown_critical_section_is_refused_by_name() {
    let tiny = Tiny::new();
    let bytes = golden("unknown-critical.pnerf", &with_unknown_section(&tiny.hash_grid(), true));
    let error = open(&bytes).unwrap_err();
    assert_eq!(error, FormatError::UnknownSection(UNKNOWN));
    assert!(error.to_string().starts_with("section of kind 0x7f index 1"), "{error}");
}
