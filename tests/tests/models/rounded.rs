//! Files with rounded networks.

use half::f16;
use pocketnerf_formats::{Container, ContainerWriter, kind};

/// An ordinary file in half precision whose networks have multiples of `step`, a power of two in
/// units of the stored values.
pub(crate) fn networks(file: &[u8], step: f32) -> Vec<u8> {
    let container = Container::open(file).expect("a sound file");
    let mut writer = ContainerWriter::new();
    for section in container.sections() {
        let mut payload = section.bytes.to_vec();
        if section.id.kind == kind::NETWORK {
            for value in payload.as_chunks_mut::<2>().0 {
                let multiple = (f16::from_le_bytes(*value).to_f32() / step).round();
                *value = f16::from_f32(multiple * step + 0.0).to_le_bytes();
            }
        }
        writer.add(section.id, section.version, section.is_critical(), payload);
    }
    writer.finish().expect("a file of the same sections")
}
