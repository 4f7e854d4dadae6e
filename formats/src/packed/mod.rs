//! Packed files: sections whose payload is coded in fewer bytes. Unpacking gives an ordinary
//! file, into the caller's memory, without a heap.

pub(crate) mod ans;
pub(crate) mod bits;
pub(crate) mod cells;
pub(crate) mod halves;
#[cfg(feature = "planes")]
pub(crate) mod planes;
pub(crate) mod tables;
#[cfg(feature = "plenoxels")]
pub(crate) mod voxels;

use crate::FormatError;
use crate::container::header::seal;
use crate::container::section::{ENTRY_BYTES, Entry};
use crate::container::{ALIGNMENT, Container, HEADER_BYTES, Header, RAW, Section, checksum};

/// Encoding of tables: SPEC, section 12.
pub const PACKED_TABLE: u16 = 1;
/// Encoding of OCC_COARSE.
pub const PACKED_BLOCKS: u16 = 2;
/// Encoding of OCC_FINE.
pub const PACKED_CELLS: u16 = 3;

/// Encoding of networks in half precision.
pub const PACKED_HALVES: u16 = 4;
/// Encoding of the values of voxels.
pub const PACKED_VOXELS: u16 = 5;
/// Encoding of planes.
pub const PACKED_PLANES: u16 = 6;

/// A packed payload stands for at most so many times its bytes.
pub(crate) const MOST_RATIO: u64 = 1 << 12;

/// Bytes of the ordinary file that a file, packed or not, stands for. O(sections); no payload is
/// touched.
///
/// # Errors
/// Those of [`Container::open`]; [`FormatError::Packed`] for a section that claims to stand for
/// more than any payload of its length does.
pub fn unpacked_len(bytes: &[u8]) -> Result<u64, FormatError> {
    let container = Container::open(bytes)?;
    let mut end = table_end(&container) as u64;
    for section in container.sections() {
        end = end_after(end, &section)?;
    }
    Ok(end)
}

/// Whether any section is packed.
///
/// # Errors
/// Those of [`Container::open`].
pub fn is_packed(bytes: &[u8]) -> Result<bool, FormatError> {
    Ok(Container::open(bytes)?.sections().any(|section| is_known(section.encoding)))
}

/// Whether sections of this encoding are unpacked here. Others, of newer programs, stay as they
/// are: whoever opens the file decides whether it can do without them.
const fn is_known(encoding: u16) -> bool {
    matches!(encoding, PACKED_TABLE..=PACKED_PLANES)
}

/// Writes the ordinary file that a file, packed or not, stands for into the first
/// [`unpacked_len`] bytes of `out`, and gives their number. Every payload is compared with its
/// checksum first. O(bytes), about 250 bytes of stack and tables of a kilobyte; with `std`, five. Voxels have
/// tables of four kilobytes, planes of three; with `std`, twenty.
///
/// # Errors
/// Those of [`unpacked_len`]; [`FormatError::Room`] for too short an `out`;
/// [`FormatError::Checksum`]; [`FormatError::Packed`] for a payload that cannot be decoded;
/// [`FormatError::FieldKind`] for voxels and planes, where they are left out.
pub fn unpack_into(bytes: &[u8], out: &mut [u8]) -> Result<usize, FormatError> {
    let needed = unpacked_len(bytes)?;
    let given = out.len() as u64;
    let container = Container::open(bytes)?;
    let Some(out) = usize::try_from(needed).ok().and_then(|needed| out.get_mut(..needed)) else {
        return Err(FormatError::Room { needed, given });
    };
    let (head, payloads) = out.split_at_mut(table_end(&container));
    let (entries, _) = head[HEADER_BYTES..].as_chunks_mut::<ENTRY_BYTES>();
    let mut end = HEADER_BYTES + entries.len() * ENTRY_BYTES;
    let mut rest = payloads;
    for (section, to) in container.sections().zip(entries) {
        section.verify()?;
        let start = end.next_multiple_of(ALIGNMENT as usize);
        let (padding, after) = core::mem::take(&mut rest).split_at_mut(start - end);
        padding.fill(0);
        // Their sum is the length of `out`.
        let (payload, after) = after.split_at_mut(length_after(&section) as usize);
        unpack_section(&section, payload)?;
        (end, rest) = (start + payload.len(), after);
        *to = Entry {
            id: section.id,
            version: section.version,
            encoding: if is_known(section.encoding) { RAW } else { section.encoding },
            flags: section.flags,
            offset: start as u64,
            stored_length: payload.len() as u64,
            decoded_length: section.decoded_length,
            checksum: checksum::hash(payload),
        }
        .to_bytes();
    }
    let header = Header { file_length: needed, checksum: 0, ..container.header() };
    head[..HEADER_BYTES].copy_from_slice(&header.to_bytes());
    seal(head);
    Ok(needed as usize)
}

/// The bytes of the ordinary file: those given, where they are one already.
///
/// # Errors
/// Those of [`unpack_into`].
#[cfg(feature = "alloc")]
pub fn unpacked(bytes: &[u8]) -> Result<alloc::borrow::Cow<'_, [u8]>, FormatError> {
    if !is_packed(bytes)? {
        return Ok(bytes.into());
    }
    let needed = unpacked_len(bytes)?;
    let room = FormatError::Room { needed, given: 0 };
    let mut out = alloc::vec::Vec::new();
    let length = usize::try_from(needed).map_err(|_| room)?;
    out.try_reserve_exact(length).map_err(|_| room)?;
    out.resize(length, 0);
    unpack_into(bytes, &mut out)?;
    Ok(out.into())
}

fn table_end(container: &Container<'_>) -> usize {
    HEADER_BYTES + container.sections().len() * ENTRY_BYTES
}

/// Where a section ends in the ordinary file, if the one before it ends at `end`.
fn end_after(end: u64, section: &Section<'_>) -> Result<u64, FormatError> {
    let (length, stored) = (length_after(section), section.bytes.len() as u64);
    let end = end.checked_next_multiple_of(ALIGNMENT);
    match end.and_then(|start| start.checked_add(length)) {
        Some(end) if length <= stored.saturating_mul(MOST_RATIO) => Ok(end),
        _ => Err(FormatError::Packed(section.id)),
    }
}

/// Bytes of a section's payload in the ordinary file.
const fn length_after(section: &Section<'_>) -> u64 {
    if is_known(section.encoding) { section.decoded_length } else { section.bytes.len() as u64 }
}

fn unpack_section(section: &Section<'_>, out: &mut [u8]) -> Result<(), FormatError> {
    let done = match section.encoding {
        PACKED_TABLE => tables::unpack(section.bytes, out),
        PACKED_BLOCKS => cells::unpack_blocks(section.bytes, out),
        PACKED_CELLS => cells::unpack_bits(section.bytes, out),
        PACKED_HALVES => halves::unpack(section.bytes, out),
        #[cfg(feature = "plenoxels")]
        PACKED_VOXELS => voxels::unpack(section.bytes, out),
        #[cfg(not(feature = "plenoxels"))]
        PACKED_VOXELS => return Err(FormatError::FieldKind("plenoxels")),
        #[cfg(feature = "planes")]
        PACKED_PLANES => planes::unpack(section.bytes, out),
        #[cfg(not(feature = "planes"))]
        PACKED_PLANES => return Err(FormatError::FieldKind("planes")),
        _ => {
            out.copy_from_slice(section.bytes);
            Some(())
        }
    };
    done.ok_or(FormatError::Packed(section.id))
}

#[cfg(all(test, feature = "alloc"))]
mod tests {
    use super::*;
    use crate::{ContainerWriter, SectionId, kind};

    /// A program without voxels or planes says so, instead of that the section is damaged.
    #[test]
    fn kinds_that_are_left_out_are_refused_by_name() {
        let id = SectionId::first(kind::GRID);
        let kinds = [
            (PACKED_VOXELS, cfg!(feature = "plenoxels"), "plenoxels"),
            (PACKED_PLANES, cfg!(feature = "planes"), "planes"),
        ];
        for (encoding, is_here, name) in kinds {
            let mut writer = ContainerWriter::new();
            writer.add_packed((id, 1, true), encoding, 64, alloc::vec![0; 8]);
            let expected =
                if is_here { FormatError::Packed(id) } else { FormatError::FieldKind(name) };
            assert_eq!(unpacked(&writer.finish().unwrap()).unwrap_err(), expected);
        }
    }
}
